//! A good file, changed by chance.

use super::{lines, render};
use config::ConfigError;
use proptest::prelude::*;

/// One change to a text.
#[derive(Clone, Debug)]
pub enum Change {
    RemoveLine(usize),
    DuplicateLine(usize, usize),
    SwapLines(usize, usize),
    Value(usize, String),
    Key(usize, String),
    Bytes(usize, usize, String),
    Cut(usize),
}

/// A value, well formed or not.
pub fn value() -> impl Strategy<Value = String> {
    prop_oneof![
        Just("nan".to_owned()),
        Just("-inf".to_owned()),
        Just("-1".to_owned()),
        Just("0".to_owned()),
        Just("1e308".to_owned()),
        Just("-0.0".to_owned()),
        Just("9223372036854775807".to_owned()),
        Just("-9223372036854775808".to_owned()),
        Just("\"\"".to_owned()),
        Just("\"1\"".to_owned()),
        Just("[]".to_owned()),
        Just("[[], [{}]]".to_owned()),
        Just("{}".to_owned()),
        Just("{ min_m = [1, 2], max_m = [3, 4] }".to_owned()),
        Just("true".to_owned()),
        Just("2026-01-01".to_owned()),
        any::<f64>().prop_map(|number| format!("{number:?}")),
        any::<i64>().prop_map(|number| number.to_string()),
        "[a-z\"'\\[\\]{}=.,# 0-9é€\\-]{0,12}",
    ]
}

/// Any change.
pub fn change() -> impl Strategy<Value = Change> {
    let at = 0..10_000_usize;
    prop_oneof![
        at.clone().prop_map(Change::RemoveLine),
        (at.clone(), at.clone()).prop_map(|(a, b)| Change::DuplicateLine(a, b)),
        (at.clone(), at.clone()).prop_map(|(a, b)| Change::SwapLines(a, b)),
        (at.clone(), value()).prop_map(|(a, text)| Change::Value(a, text)),
        (at.clone(), value()).prop_map(|(a, text)| Change::Value(a, text)),
        (at.clone(), "[a-z0-9_.\"\\-]{0,10}").prop_map(|(a, text)| Change::Key(a, text)),
        (at.clone(), 0..20_usize, any::<String>())
            .prop_map(|(a, n, text)| Change::Bytes(a, n, text)),
        at.prop_map(Change::Cut),
    ]
}

/// The text with the changes made one after the other.
pub fn apply(text: &str, changes: &[Change]) -> String {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    // Comments would take most of the changes.
    lines.retain(|line| !line.starts_with('#') && !line.is_empty());
    let mut text = lines.join("\n");
    for change in changes {
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        let count = lines.len().max(1);
        if lines.is_empty() {
            lines.push(String::new());
        }
        match change {
            Change::RemoveLine(at) => drop(lines.remove(at % count)),
            Change::DuplicateLine(from, to) => {
                let line = lines[from % count].clone();
                lines.insert(to % count, line);
            }
            Change::SwapLines(a, b) => lines.swap(a % count, b % count),
            Change::Value(at, value) => {
                if let Some((key, _)) = lines[at % count].clone().split_once('=') {
                    lines[at % count] = format!("{key}= {value}");
                }
            }
            Change::Key(at, key) => {
                if let Some((_, value)) = lines[at % count].clone().split_once('=') {
                    lines[at % count] = format!("{key} ={value}");
                }
            }
            Change::Bytes(..) | Change::Cut(_) => {}
        }
        text = lines.join("\n");
        let chars: Vec<char> = text.chars().collect();
        match change {
            Change::Bytes(at, length, with) => {
                let start = at % (chars.len() + 1);
                let end = (start + length).min(chars.len());
                text = chars[..start]
                    .iter()
                    .chain(&with.chars().collect::<Vec<_>>())
                    .chain(&chars[end..])
                    .collect();
            }
            Change::Cut(at) => text = chars[..at % (chars.len() + 1)].iter().collect(),
            _ => {}
        }
    }
    text
}

/// What holds for every error.
pub fn sound(error: &ConfigError, text: &str) {
    assert!(!error.problems().is_empty());
    let last_line = text.matches('\n').count() + 1;
    for problem in error.problems() {
        assert_eq!(problem.file, "some.toml", "{}", lines(error));
        let line = problem.line.unwrap_or_else(|| panic!("no line: {problem}"));
        assert!((1..=last_line).contains(&line), "{problem}");
        assert!(
            !problem.found.is_empty() && !problem.expected.is_empty(),
            "{problem}"
        );
    }
    assert!(!render(error).is_empty());
}
