//! Single values: numbers, texts, words.

use description::keys::{Count, Quantity, quoted_list};

use super::section::Section;
use crate::diagnostic::ProblemKind;
use crate::hint;
use crate::node::{Node, Value};

impl<'a> Section<'a> {
    pub(super) fn read_number(&self, path: &str, node: &Node, quantity: &Quantity) -> f64 {
        let value = match &node.value {
            Value::Float(value) => *value,
            Value::Integer(value) => *value as f64,
            other => {
                let expected = quantity.describe();
                let mut problem =
                    self.report
                        .problem(ProblemKind::WrongType, path, other.show(), expected);
                if let Value::Text(text) = other {
                    problem = match hint::convert_text(text, quantity.unit) {
                        Some(number) => {
                            problem.with_hint(format!("write the number alone: {number}"))
                        }
                        None => problem.with_hint("write the number without quotes"),
                    };
                }
                self.report.push(problem);
                return f64::NAN;
            }
        };
        if quantity.holds(value) {
            return value;
        }
        let mut problem = self.report.problem(
            ProblemKind::OutOfRange,
            path,
            node.value.show(),
            quantity.describe(),
        );
        if let Some(advice) = quantity.other_unit(value) {
            problem = problem.with_hint(advice);
        }
        self.report.push(problem);
        f64::NAN
    }

    pub(super) fn read_count(&self, path: &str, node: &Node, count: &Count) -> u32 {
        let kind = match &node.value {
            Value::Integer(value) if count.holds(*value) => {
                return u32::try_from(*value).unwrap_or(0);
            }
            Value::Integer(_) | Value::HugeInteger(_) => ProblemKind::OutOfRange,
            _ => ProblemKind::WrongType,
        };
        self.report
            .wrong(kind, path, node.value.show(), count.describe());
        0
    }

    pub(super) fn read_text(&self, path: &str, node: &Node, expected: &str) -> String {
        match &node.value {
            Value::Text(text) if text.trim().is_empty() || text.contains(['\0', '\n']) => {
                self.report.wrong(
                    ProblemKind::OutOfRange,
                    path,
                    node.value.show(),
                    format!("{expected}, one line, not empty"),
                );
                String::new()
            }
            Value::Text(text) => text.clone(),
            other => {
                self.wrong_type(path, other, expected);
                String::new()
            }
        }
    }

    pub(super) fn read_word(
        &self,
        path: &str,
        node: &Node,
        words: &[&'static str],
    ) -> Option<&'static str> {
        let expected = quoted_list(words, "or");
        let Value::Text(text) = &node.value else {
            self.wrong_type(path, &node.value, &expected);
            return None;
        };
        if let Some(word) = words.iter().find(|word| *word == text) {
            return Some(word);
        }
        let mut problem =
            self.report
                .problem(ProblemKind::OutOfRange, path, node.value.show(), &expected);
        if let Some(near) = hint::nearest(text, words) {
            problem = problem.with_hint(format!("did you mean `{near}`?"));
        }
        self.report.push(problem);
        None
    }

    /// The items of an array, each with its path.
    pub(super) fn items(
        &self,
        path: &str,
        node: &'a Node,
        expected: &str,
    ) -> Vec<(String, &'a Node)> {
        let Value::Array(items) = &node.value else {
            self.wrong_type(path, &node.value, expected);
            return Vec::new();
        };
        let item = |(index, item)| (format!("{path}[{index}]"), item);
        items.iter().enumerate().map(item).collect()
    }

    /// As [`Section::items`], where none is a problem.
    pub(super) fn some_items(
        &self,
        path: &str,
        node: &'a Node,
        expected: &str,
    ) -> Vec<(String, &'a Node)> {
        if matches!(&node.value, Value::Array(items) if items.is_empty()) {
            self.report
                .wrong(ProblemKind::OutOfRange, path, "an empty array", expected);
        }
        self.items(path, node, expected)
    }
}
