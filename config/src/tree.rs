//! The text of a file as a tree in which every key and value knows its place.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::diagnostic::{ConfigError, Problem, ProblemKind};
use crate::node::{Entry, Node, Value};
use crate::origin::Origin;
use crate::report::MOST_PROBLEMS;
use crate::spot::{Spot, join};

/// Parses a document; on syntax errors returns them and no tree.
pub(crate) fn parse_document(text: &str, origin: &Origin) -> Result<Vec<Entry>, ConfigError> {
    let (table, errors) = DeTable::parse_recoverable(text);
    if errors.is_empty() {
        return Ok(convert_table(table.get_ref(), 0, 0));
    }
    // What could be read tells where a name stood first.
    let read = origin.with_places(&convert_table(table.get_ref(), 0, 0));
    let mut problems: Vec<Problem> = Vec::new();
    // Each takes time in proportion to the text.
    let omitted = errors.len().saturating_sub(MOST_PROBLEMS);
    for error in errors.iter().take(MOST_PROBLEMS) {
        let problem = syntax_problem(text, error, &read);
        // Below a header that stands twice every key stands twice.
        let follows = |earlier: &Problem| {
            earlier.kind == ProblemKind::Duplicate
                && problem
                    .key
                    .strip_prefix(&earlier.key)
                    .is_some_and(|rest| rest.starts_with('.'))
        };
        if problem.kind == ProblemKind::Duplicate && problems.iter().any(follows) {
            continue;
        }
        problems.push(problem);
    }
    Err(ConfigError::new(problems, omitted))
}

/// Parses one value that starts at byte `offset` of its source.
pub(crate) fn parse_value(text: &str, offset: usize) -> Result<Node, String> {
    match DeValue::parse(text) {
        Ok(value) => Ok(convert(&value, 0, offset)),
        Err(error) => Err(error.message().to_owned()),
    }
}

/// Puts another source number on a whole tree.
pub(crate) fn set_source(node: &mut Node, source: usize) {
    node.spot.source = source;
    match &mut node.value {
        Value::Array(items) => items.iter_mut().for_each(|item| set_source(item, source)),
        Value::Table(entries) => {
            for entry in entries {
                entry.spot.source = source;
                set_source(&mut entry.node, source);
            }
        }
        _ => {}
    }
}

fn convert_table(table: &DeTable<'_>, source: usize, offset: usize) -> Vec<Entry> {
    let mut entries: Vec<Entry> = table
        .iter()
        .map(|(key, value)| Entry {
            key: key.get_ref().to_string(),
            spot: spot(key.span(), source, offset),
            node: convert(value, source, offset),
        })
        .collect();
    entries.sort_by_key(|entry| entry.spot.span.start);
    entries
}

fn convert(value: &Spanned<DeValue<'_>>, source: usize, offset: usize) -> Node {
    let converted = match value.get_ref() {
        DeValue::String(text) => Value::Text(text.to_string()),
        DeValue::Integer(integer) => match i64::from_str_radix(integer.as_str(), integer.radix()) {
            Ok(number) => Value::Integer(number),
            Err(_) => Value::HugeInteger(integer.to_string()),
        },
        DeValue::Float(float) => Value::Float(float.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(truth) => Value::Boolean(*truth),
        DeValue::Datetime(time) => Value::Datetime(time.to_string()),
        DeValue::Array(items) => Value::Array(
            items
                .iter()
                .map(|item| convert(item, source, offset))
                .collect(),
        ),
        DeValue::Table(table) => Value::Table(convert_table(table, source, offset)),
    };
    Node {
        spot: spot(value.span(), source, offset),
        value: converted,
    }
}

fn spot(span: Range<usize>, source: usize, offset: usize) -> Spot {
    Spot {
        source,
        span: span.start + offset..span.end + offset,
    }
}

fn syntax_problem(text: &str, error: &toml::de::Error, origin: &Origin) -> Problem {
    let span = error.span().unwrap_or(text.len()..text.len());
    let start = floor_boundary(text, span.start);
    let line_start = text[..start].rfind('\n').map_or(0, |at| at + 1);
    let line_end = text[start..].find('\n').map_or(text.len(), |at| start + at);
    let line = text[line_start..line_end].trim();
    let section = section_before(text, line_start);
    let spot = Some(Spot {
        source: 0,
        span: span.clone(),
    });

    if error.message().contains("duplicate key") {
        let end = floor_boundary(text, span.end.max(start));
        let name = text[start..end].trim().trim_matches(['[', ']']).trim();
        let key = if line.starts_with('[') {
            line.trim_matches(['[', ']', ' ']).to_owned()
        } else {
            join(section, name)
        };
        let problem = origin.problem_at(
            ProblemKind::Duplicate,
            &key,
            spot,
            format!("`{name}` a second time"),
            "each name once".to_owned(),
        );
        return origin.also(problem, &key, "first here");
    }
    let key = match line.split_once('=') {
        Some((key, _)) => join(section, key.trim()),
        None => line.trim_matches(['[', ']', ' ']).to_owned(),
    };
    let shown: String = line.chars().take(60).collect();
    let found = if line.is_empty() {
        "the end of the line".to_owned()
    } else {
        format!("`{shown}`")
    };
    let message = error.message().trim();
    origin.problem_at(
        ProblemKind::Syntax,
        &key,
        spot,
        found,
        format!("valid TOML ({message})"),
    )
}

/// The last `[section]` header before an offset.
fn section_before(text: &str, end: usize) -> &str {
    text[..end]
        .lines()
        .rev()
        .map(str::trim)
        .find(|line| line.starts_with('[') && line.ends_with(']'))
        .map_or("", |line| line.trim_matches(['[', ']', ' ']))
}

fn floor_boundary(text: &str, offset: usize) -> usize {
    let mut at = offset.min(text.len());
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}
