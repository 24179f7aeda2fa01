//! Values of a section: numbers, words, texts, points.

use crate::diagnostic::ProblemKind;
use crate::geometry::{PoseConfig, Rect};
use crate::hint;
use crate::quantity::{ANGLE, Count, Quantity};
use crate::reader::Section;
use crate::tree::{Node, Value};

impl Section<'_> {
    pub(super) fn wrong_type(&self, key: &str, value: &Value, expected: &str) {
        self.report.push(
            self.report
                .problem(ProblemKind::WrongType, key, value.show(), expected),
        );
    }

    /// A required number.
    pub(crate) fn number(&self, key: &'static str, quantity: Quantity) -> f64 {
        let node = self.required(key, &quantity.describe());
        node.map_or(f64::NAN, |node| {
            self.read_number(&self.at(key), node, &quantity)
        })
    }

    /// A number with a default.
    pub(crate) fn number_or(&self, key: &'static str, quantity: Quantity, default: f64) -> f64 {
        let node = self.optional(key);
        node.map_or(default, |node| {
            self.read_number(&self.at(key), node, &quantity)
        })
    }

    /// A number that may be absent.
    pub(crate) fn number_if(&self, key: &'static str, quantity: Quantity) -> Option<f64> {
        self.optional(key)
            .map(|node| self.read_number(&self.at(key), node, &quantity))
    }

    fn read_number(&self, key: &str, node: &Node, quantity: &Quantity) -> f64 {
        let value = match &node.value {
            Value::Float(value) => *value,
            Value::Integer(value) => *value as f64,
            other => {
                let expected = quantity.describe();
                let mut problem =
                    self.report
                        .problem(ProblemKind::WrongType, key, other.show(), expected);
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
            key,
            node.value.show(),
            quantity.describe(),
        );
        if let Some(advice) = quantity.other_unit(value) {
            problem = problem.with_hint(advice);
        }
        self.report.push(problem);
        f64::NAN
    }

    /// A required whole number; `Count`'s limits keep it inside `u32`.
    pub(crate) fn integer(&self, key: &'static str, count: Count) -> u32 {
        let node = self.required(key, &count.describe());
        node.map_or(0, |node| self.read_integer(&self.at(key), node, &count))
    }

    /// A whole number with a default.
    pub(crate) fn integer_or(&self, key: &'static str, count: Count, default: u32) -> u32 {
        self.optional(key).map_or(default, |node| {
            self.read_integer(&self.at(key), node, &count)
        })
    }

    fn read_integer(&self, key: &str, node: &Node, count: &Count) -> u32 {
        let kind = match &node.value {
            Value::Integer(value) if (count.min..=count.max).contains(value) => {
                return u32::try_from(*value).unwrap_or(0);
            }
            Value::Integer(_) | Value::HugeInteger(_) => ProblemKind::OutOfRange,
            _ => ProblemKind::WrongType,
        };
        self.report.push(
            self.report
                .problem(kind, key, node.value.show(), count.describe()),
        );
        0
    }

    /// A required list of whole numbers, at least one.
    pub(crate) fn integers(&self, key: &'static str, count: Count) -> Vec<u32> {
        let expected = format!("an array of {}", count.describe());
        let Some(node) = self.required(key, &expected) else {
            return Vec::new();
        };
        let Value::Array(items) = &node.value else {
            self.wrong_type(&self.at(key), &node.value, &expected);
            return Vec::new();
        };
        if items.is_empty() {
            let problem = self.report.problem(
                ProblemKind::OutOfRange,
                &self.at(key),
                "an empty array",
                &expected,
            );
            self.report.push(problem);
        }
        let item_key = |index| format!("{}[{index}]", self.at(key));
        items
            .iter()
            .enumerate()
            .map(|(index, item)| self.read_integer(&item_key(index), item, &count))
            .collect()
    }

    /// A required truth value.
    pub(crate) fn boolean(&self, key: &'static str) -> bool {
        self.required(key, "true or false")
            .is_some_and(|node| self.read_boolean(key, node))
    }

    /// A truth value with a default.
    pub(crate) fn boolean_or(&self, key: &'static str, default: bool) -> bool {
        self.optional(key)
            .map_or(default, |node| self.read_boolean(key, node))
    }

    fn read_boolean(&self, key: &str, node: &Node) -> bool {
        if let Value::Boolean(truth) = node.value {
            return truth;
        }
        self.wrong_type(&self.at(key), &node.value, "true or false");
        false
    }

    /// A required text that is not empty.
    pub(crate) fn text(&self, key: &'static str, expected: &str) -> String {
        let node = self.required(key, expected);
        node.map_or_else(String::new, |node| {
            self.read_text(&self.at(key), node, expected)
        })
    }

    /// A text that may be absent.
    pub(crate) fn text_if(&self, key: &'static str, expected: &str) -> Option<String> {
        self.optional(key)
            .map(|node| self.read_text(&self.at(key), node, expected))
    }

    pub(super) fn read_text(&self, key: &str, node: &Node, expected: &str) -> String {
        match &node.value {
            Value::Text(text) if text.trim().is_empty() || text.contains(['\0', '\n']) => {
                let found = node.value.show();
                self.report.push(self.report.problem(
                    ProblemKind::OutOfRange,
                    key,
                    found,
                    format!("{expected}, one line, not empty"),
                ));
                String::new()
            }
            Value::Text(text) => text.clone(),
            other => {
                self.wrong_type(key, other, expected);
                String::new()
            }
        }
    }

    /// A list of texts, empty when absent.
    pub(crate) fn texts(&self, key: &'static str, expected: &str) -> Vec<String> {
        self.optional(key)
            .map_or_else(Vec::new, |node| self.read_texts(key, node, expected))
    }

    fn read_texts(&self, key: &str, node: &Node, expected: &str) -> Vec<String> {
        let key = self.at(key);
        let Value::Array(items) = &node.value else {
            self.wrong_type(&key, &node.value, &format!("an array: {expected}"));
            return Vec::new();
        };
        items
            .iter()
            .enumerate()
            .map(|(index, item)| self.read_text(&format!("{key}[{index}]"), item, expected))
            .collect()
    }

    /// A required word out of a few.
    pub(crate) fn choice<T: Copy>(&self, key: &'static str, choices: &[(&str, T)]) -> Option<T> {
        let names: Vec<&str> = choices.iter().map(|(name, _)| *name).collect();
        let node = self.required(key, &hint::list(&names, "or"))?;
        self.read_choice(&self.at(key), node, choices)
    }

    fn read_choice<T: Copy>(&self, key: &str, node: &Node, choices: &[(&str, T)]) -> Option<T> {
        let names: Vec<&str> = choices.iter().map(|(name, _)| *name).collect();
        let expected = hint::list(&names, "or");
        let Value::Text(text) = &node.value else {
            self.wrong_type(key, &node.value, &expected);
            return None;
        };
        if let Some((_, value)) = choices.iter().find(|(name, _)| name == text) {
            return Some(*value);
        }
        let mut problem =
            self.report
                .problem(ProblemKind::OutOfRange, key, node.value.show(), &expected);
        if let Some(near) = hint::nearest(text, &names) {
            problem = problem.with_hint(format!("did you mean `{near}`?"));
        }
        self.report.push(problem);
        None
    }

    /// A list of words out of a few; `None` keeps the place of a wrong one.
    pub(crate) fn choices<T: Copy>(
        &self,
        key: &'static str,
        choices: &[(&str, T)],
        required: bool,
    ) -> Vec<Option<T>> {
        let names: Vec<&str> = choices.iter().map(|(name, _)| *name).collect();
        let expected = format!("an array of {}", hint::list(&names, "or"));
        let node = if required {
            self.required(key, &expected)
        } else {
            self.optional(key)
        };
        let Some(node) = node else { return Vec::new() };
        let key = self.at(key);
        let Value::Array(items) = &node.value else {
            self.wrong_type(&key, &node.value, &expected);
            return Vec::new();
        };
        items
            .iter()
            .enumerate()
            .map(|(index, item)| self.read_choice(&format!("{key}[{index}]"), item, choices))
            .collect()
    }

    /// A value that is either a number or a word: reads it with the caller's rule.
    pub(crate) fn custom<T>(
        &self,
        key: &'static str,
        expected: &str,
        read: impl FnOnce(&Value) -> Option<T>,
    ) -> Option<T> {
        let node = self.required(key, expected)?;
        let value = read(&node.value);
        if value.is_none() {
            let kind = match node.value {
                Value::Text(_) | Value::Integer(_) | Value::HugeInteger(_) => {
                    ProblemKind::OutOfRange
                }
                _ => ProblemKind::WrongType,
            };
            let problem = self
                .report
                .problem(kind, &self.at(key), node.value.show(), expected);
            self.report.push(problem);
        }
        value
    }

    /// A required point `[x, y]`.
    pub(crate) fn point(&self, key: &'static str, quantity: Quantity) -> [f64; 2] {
        let expected = format!("[x, y], each {}", quantity.describe());
        let Some(node) = self.required(key, &expected) else {
            return [f64::NAN; 2];
        };
        let path = self.at(key);
        match &node.value {
            Value::Array(items) if items.len() == 2 => {
                let number = |axis: usize| {
                    self.read_number(&format!("{path}[{axis}]"), &items[axis], &quantity)
                };
                [number(0), number(1)]
            }
            other => {
                self.wrong_type(&path, other, &expected);
                [f64::NAN; 2]
            }
        }
    }

    /// A required table `{ min_m = [x, y], max_m = [x, y] }`.
    pub(crate) fn rect(&self, key: &'static str, quantity: Quantity) -> Rect {
        self.section(
            key,
            "a rectangle { min_m = [x, y], max_m = [x, y] }",
            |table| {
                let rect = Rect {
                    min_m: table.point("min_m", quantity),
                    max_m: table.point("max_m", quantity),
                };
                let ([x0, y0], [x1, y1]) = (rect.min_m, rect.max_m);
                if x1 <= x0 || y1 <= y0 {
                    table.report.push(table.report.problem(
                        ProblemKind::Inconsistent,
                        &table.at("max_m"),
                        format!("[{x1:?}, {y1:?}]"),
                        format!("a corner north-east of min_m [{x0:?}, {y0:?}]"),
                    ));
                }
                rect
            },
        )
    }

    /// A required table `{ x_m = …, y_m = …, theta_rad = … }`.
    pub(crate) fn pose(&self, key: &'static str, quantity: Quantity) -> PoseConfig {
        self.section(
            key,
            "a pose { x_m = …, y_m = …, theta_rad = … }",
            |table| PoseConfig {
                x_m: table.number("x_m", quantity),
                y_m: table.number("y_m", quantity),
                theta_rad: table.number("theta_rad", ANGLE),
            },
        )
    }
}
