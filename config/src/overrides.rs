//! `--set key=value`: a value from the command line in place of the file's.

use std::str::FromStr;
use std::sync::Arc;

use description::keys::Section;
use description::robot::Robot;
use description::site::Site;
use miette::NamedSource;

use crate::diagnostic::{ConfigError, Problem, ProblemKind};
use crate::hint;
use crate::node::{Entry, Node, Value};
use crate::spot::{Source, Spot};
use crate::tree;

/// No file nests deeper.
const DEEPEST: usize = 8;
/// What a file says of itself, in files of every kind: nothing to set from outside.
pub(crate) const OF_THE_FILE: &str = "metamodel";

/// One `key=value`, such as `drive.max_speed_m_s=0.3`.
///
/// The value is TOML; what is not (`eth1`, `/dev/ttyACM0`) is taken as text.
/// It goes to the file that has the key's first part.
#[derive(Clone, Debug)]
pub struct Override {
    typed: String,
    keys: Vec<(String, Spot)>,
    value: Node,
}

impl Override {
    /// Reads `a.b=value`.
    ///
    /// # Errors
    /// If there is no `=`, the key begins with no section of a file, or the value is not TOML.
    pub fn parse(typed: &str) -> Result<Override, ConfigError> {
        let problem = |key: &str, found: String, expected: &str| {
            Problem::new(ProblemKind::Override, key, found, expected).in_file(name(typed))
        };
        let shape = "key=value, such as drive.max_speed_m_s=0.3";
        let Some((key, value)) = typed.split_once('=') else {
            return Err(problem("", format!("`{typed}`"), shape).into());
        };
        let keys = split_key(key);
        if keys.iter().any(|(part, _)| part.is_empty()) {
            return Err(problem(key.trim(), format!("the key `{}`", key.trim()), shape).into());
        }
        if keys.len() > DEEPEST {
            let found = format!("a key of {} parts", keys.len());
            return Err(problem("", found, "at most 8 parts").into());
        }
        if value.trim().is_empty() {
            let expected = "a value behind the `=`; \"\" for an empty text";
            return Err(problem(key.trim(), "nothing".to_owned(), expected).into());
        }
        let top = keys.first().map_or("", |(part, _)| part.as_str());
        let sections = Robot::KEYS.iter().chain(Site::KEYS).copied();
        let sections: Vec<&str> = sections.filter(|&key| key != OF_THE_FILE).collect();
        if !sections.contains(&top) {
            let expected = format!("one of {}", description::keys::quoted_list(&sections, "or"));
            let mut wrong = problem(key.trim(), format!("`{top}`"), &expected);
            if let Some(near) = hint::nearest(top, &sections) {
                wrong = wrong.with_hint(format!("did you mean `{near}`?"));
            }
            return Err(wrong.into());
        }
        let offset = key.len() + 1;
        let value = read_value(value, offset)
            .map_err(|message| problem(key.trim(), format!("`{}`", value.trim()), &message))?;
        Ok(Override {
            typed: typed.to_owned(),
            keys,
            value,
        })
    }

    /// As it was typed, without `--set`.
    #[must_use]
    pub fn typed(&self) -> &str {
        &self.typed
    }

    pub(crate) fn belongs_to(&self, sections: &[&str]) -> bool {
        self.keys
            .first()
            .is_some_and(|(part, _)| sections.contains(&part.as_str()))
    }

    pub(crate) fn source(&self) -> Source {
        let text = NamedSource::new(name(&self.typed), self.typed.clone());
        Source {
            text: Arc::new(text),
            is_file: false,
        }
    }

    /// Puts the value into the tree; fails where a part of the key is no table.
    pub(crate) fn apply(&self, root: &mut Vec<Entry>, source: usize) -> Result<(), ConfigError> {
        let mut table = root;
        let Some(((last, last_spot), path)) = self.keys.split_last() else {
            return Ok(());
        };
        for (depth, (part, spot)) in path.iter().enumerate() {
            let at = position_or_insert(table, part, spot, source);
            let shown = table[at].node.value.show();
            let Value::Table(inner) = &mut table[at].node.value else {
                let whole: Vec<&str> = self.keys[..=depth]
                    .iter()
                    .map(|(part, _)| part.as_str())
                    .collect();
                return Err(self.not_a_table(&whole.join("."), shown).into());
            };
            table = inner;
        }
        let at = position_or_insert(table, last, last_spot, source);
        let mut value = self.value.clone();
        tree::set_source(&mut value, source);
        table[at].spot = Spot {
            source,
            span: last_spot.span.clone(),
        };
        table[at].node = value;
        Ok(())
    }

    fn not_a_table(&self, key: &str, shown: String) -> Problem {
        let expected = "a table, to set a key in it";
        Problem::new(ProblemKind::Override, key, shown, expected)
            .in_file(name(&self.typed))
            .with_hint(format!("set `{key}` as a whole"))
    }
}

impl FromStr for Override {
    type Err = ConfigError;

    fn from_str(typed: &str) -> Result<Self, Self::Err> {
        Override::parse(typed)
    }
}

fn name(typed: &str) -> String {
    format!("--set {typed}")
}

fn split_key(key: &str) -> Vec<(String, Spot)> {
    let mut start = 0;
    key.split('.')
        .map(|part| {
            let span = start..start + part.len();
            start = span.end + 1;
            (part.trim().to_owned(), Spot { source: 0, span })
        })
        .collect()
}

fn read_value(text: &str, offset: usize) -> Result<Node, String> {
    let start = offset + (text.len() - text.trim_start().len());
    let trimmed = text.trim();
    match tree::parse_value(trimmed, start) {
        Ok(node) => Ok(node),
        // A value that begins like TOML was meant as TOML.
        Err(message) if trimmed.starts_with(['[', '{', '"', '\'']) => {
            Err(format!("a TOML value ({message})"))
        }
        Err(_) => {
            let spot = Spot {
                source: 0,
                span: start..start + trimmed.len(),
            };
            Ok(Node {
                spot,
                value: Value::Text(trimmed.to_owned()),
            })
        }
    }
}

fn position_or_insert(table: &mut Vec<Entry>, key: &str, spot: &Spot, source: usize) -> usize {
    if let Some(at) = table.iter().position(|entry| entry.key == key) {
        return at;
    }
    let spot = Spot {
        source,
        span: spot.span.clone(),
    };
    let node = Node {
        spot: spot.clone(),
        value: Value::Table(Vec::new()),
    };
    table.push(Entry {
        key: key.to_owned(),
        spot,
        node,
    });
    table.len() - 1
}
