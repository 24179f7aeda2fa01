//! The shipped files, edited into broken ones, and what must be said about them.

#![allow(dead_code, reason = "each test program uses its own part")]

pub mod mutation;

use config::{ConfigError, Override, Problem, ProblemKind};

/// The shipped robot file.
pub const ROBOT: &str = include_str!("../../../robots/amr-1.toml");
/// The shipped site file.
pub const SITE: &str = include_str!("../../../sites/corridor.toml");

/// One mistake and what must be said about it.
pub struct Mistake {
    /// What is broken; shown when the test fails.
    pub name: &'static str,
    /// Text that occurs exactly once,
    pub from: &'static str,
    /// and what takes its place.
    pub to: &'static str,
    /// The sort of problem.
    pub kind: ProblemKind,
    /// The full key.
    pub key: &'static str,
    /// Text of the line that must be named; its first occurrence after the edit.
    pub line: &'static str,
    /// What was found, in full.
    pub found: &'static str,
    /// A part of what was expected.
    pub expected: &'static str,
    /// A part of the advice; empty: not looked at.
    pub hint: &'static str,
}

/// Replaces text that occurs exactly once.
pub fn edit(text: &str, from: &str, to: &str) -> String {
    assert_eq!(text.matches(from).count(), 1, "{from:?} must occur once");
    text.replacen(from, to, 1)
}

/// The 1-based line on which the text first occurs.
pub fn line_of(text: &str, needle: &str) -> usize {
    let at = text
        .find(needle)
        .unwrap_or_else(|| panic!("{needle:?} is not in the text"));
    text[..at].matches('\n').count() + 1
}

/// Overrides as typed.
pub fn sets(typed: &[&str]) -> Vec<Override> {
    typed
        .iter()
        .map(|text| Override::parse(text).expect("a good override"))
        .collect()
}

/// Every mistake must give exactly one problem, and the right one.
pub fn check(
    mistakes: &[Mistake],
    original: &str,
    parse: impl Fn(&str, &str) -> Option<ConfigError>,
) {
    for mistake in mistakes {
        let text = edit(original, mistake.from, mistake.to);
        let error =
            parse("some.toml", &text).unwrap_or_else(|| panic!("{}: accepted", mistake.name));
        let [problem] = error.problems() else {
            panic!("{}: several problems: {}", mistake.name, lines(&error));
        };
        let line = line_of(&text, mistake.line);
        assert_problem(problem, mistake, line);
        let rendered = render(&error);
        for part in ["some.toml", mistake.key, mistake.found] {
            assert!(
                rendered.contains(part),
                "{}: {part:?} is not printed:\n{rendered}",
                mistake.name
            );
        }
    }
}

fn assert_problem(problem: &Problem, mistake: &Mistake, line: usize) {
    let name = mistake.name;
    assert_eq!(problem.kind, mistake.kind, "{name}: {problem}");
    assert_eq!(problem.file, "some.toml", "{name}: {problem}");
    assert_eq!(problem.key, mistake.key, "{name}: {problem}");
    assert_eq!(problem.line, Some(line), "{name}: {problem}");
    assert_eq!(problem.found, mistake.found, "{name}: {problem}");
    assert!(
        problem.expected.contains(mistake.expected),
        "{name}: {problem}"
    );
    let hint = problem.hint.as_deref().unwrap_or_default();
    assert!(
        hint.contains(mistake.hint),
        "{name}: the advice is {hint:?}"
    );
}

/// All problems, one a line.
pub fn lines(error: &ConfigError) -> String {
    error
        .problems()
        .iter()
        .map(|problem| format!("\n  {problem}"))
        .collect()
}

/// What a user sees, on one very wide line without colours.
pub fn render(error: &ConfigError) -> String {
    let handler = miette::GraphicalReportHandler::new_themed(miette::GraphicalTheme::none());
    let mut text = String::new();
    handler
        .with_width(4000)
        .render_report(&mut text, error)
        .expect("it prints");
    text
}
