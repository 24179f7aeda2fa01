//! Reads typed values out of the tree and collects every problem on the way.
//!
//! A value that is missing or wrong is reported and replaced by a placeholder
//! (NaN, 0, empty), so that reading goes on; a file with problems never becomes
//! a configuration. What a section is asked for is what it knows: every other
//! key in it is reported as unknown.

use std::cell::{Cell, RefCell};

use crate::diagnostic::{ConfigError, Problem, ProblemKind};
use crate::geometry::{PoseConfig, Rect};
use crate::hint;
use crate::origin::{Origin, join};
use crate::quantity::{ANGLE, Count, Quantity};
use crate::tree::{Entry, Node, Value};

/// More problems than this help nobody.
const MOST_PROBLEMS: usize = 100;

/// Collects problems.
pub(crate) struct Report {
    pub(crate) origin: Origin,
    problems: RefCell<Vec<Problem>>,
    omitted: Cell<usize>,
}

impl Report {
    pub(crate) fn new(origin: Origin) -> Self {
        Self {
            origin,
            problems: RefCell::default(),
            omitted: Cell::new(0),
        }
    }

    pub(crate) fn push(&self, problem: Problem) {
        let mut problems = self.problems.borrow_mut();
        if problems.len() < MOST_PROBLEMS {
            problems.push(problem);
        } else {
            self.omitted.set(self.omitted.get() + 1);
        }
    }

    /// Whether any of these keys, what is below it or what is around it already has a problem.
    pub(crate) fn touched(&self, keys: &[&str]) -> bool {
        let below = |key: &str, outer: &str| {
            key.strip_prefix(outer)
                .is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
        };
        self.problems.borrow().iter().any(|problem| {
            keys.iter()
                .any(|key| below(&problem.key, key) || below(key, &problem.key))
        })
    }

    /// Pushes a problem that needs no more than this.
    pub(crate) fn wrong(
        &self,
        kind: ProblemKind,
        key: &str,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) {
        self.push(self.problem(kind, key, found, expected));
    }

    /// A problem ready to be refined and pushed.
    pub(crate) fn problem(
        &self,
        kind: ProblemKind,
        key: &str,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Problem {
        self.origin.problem(kind, key, found, expected)
    }

    /// The value, if nothing was wrong.
    pub(crate) fn finish<T>(self, value: T) -> Result<T, ConfigError> {
        let problems = self.problems.into_inner();
        if problems.is_empty() {
            Ok(value)
        } else {
            Err(ConfigError::new(problems, self.omitted.get()))
        }
    }
}

/// A table of the file, while it is being read.
pub(crate) struct Section<'a> {
    report: &'a Report,
    path: String,
    /// None: the section is absent, was reported, and stays silent.
    entries: Option<&'a [Entry]>,
    known: RefCell<Vec<&'static str>>,
    missing: RefCell<Vec<(&'static str, String)>>,
}

impl<'a> Section<'a> {
    /// Reads the whole document.
    pub(crate) fn root<T>(
        report: &'a Report,
        entries: &'a [Entry],
        read: impl FnOnce(&Section<'a>) -> T,
    ) -> T {
        Self::read(report, String::new(), Some(entries), read)
    }

    fn read<T>(
        report: &'a Report,
        path: String,
        entries: Option<&'a [Entry]>,
        read: impl FnOnce(&Section<'a>) -> T,
    ) -> T {
        let section = Section {
            report,
            path,
            entries,
            known: RefCell::default(),
            missing: RefCell::default(),
        };
        let value = read(&section);
        section.finish();
        value
    }

    /// The full key of one of this section's keys.
    pub(crate) fn at(&self, key: &str) -> String {
        join(&self.path, key)
    }

    /// Whether the key is written.
    pub(crate) fn has(&self, key: &'static str) -> bool {
        self.optional(key).is_some()
    }

    fn optional(&self, key: &'static str) -> Option<&'a Node> {
        let mut known = self.known.borrow_mut();
        if !known.contains(&key) {
            known.push(key);
        }
        self.entries?
            .iter()
            .find(|entry| entry.key == key)
            .map(|entry| &entry.node)
    }

    fn required(&self, key: &'static str, expected: &str) -> Option<&'a Node> {
        let node = self.optional(key);
        if node.is_none() && self.entries.is_some() {
            self.missing.borrow_mut().push((key, expected.to_owned()));
        }
        node
    }

    fn wrong_type(&self, key: &str, value: &Value, expected: &str) {
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

    fn read_text(&self, key: &str, node: &Node, expected: &str) -> String {
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

    /// A required table.
    pub(crate) fn section<T>(
        &self,
        key: &'static str,
        expected: &str,
        read: impl FnOnce(&Section<'a>) -> T,
    ) -> T {
        let node = self.required(key, expected);
        self.read_section(key, node, expected, read)
    }

    /// A table whose keys all have defaults.
    pub(crate) fn section_or_defaults<T>(
        &self,
        key: &'static str,
        read: impl FnOnce(&Section<'a>) -> T,
    ) -> T {
        match self.optional(key) {
            None => Self::read(self.report, self.at(key), None, read),
            node => self.read_section(key, node, "a table", read),
        }
    }

    fn read_section<T>(
        &self,
        key: &str,
        node: Option<&'a Node>,
        expected: &str,
        read: impl FnOnce(&Section<'a>) -> T,
    ) -> T {
        let entries = match node.map(|node| &node.value) {
            Some(Value::Table(entries)) => Some(entries.as_slice()),
            Some(other) => {
                self.wrong_type(&self.at(key), other, expected);
                None
            }
            None => None,
        };
        Self::read(self.report, self.at(key), entries, read)
    }

    /// Every key not asked for so far, as a table named by its key.
    pub(crate) fn each<T>(&self, read: impl Fn(&str, &Section<'a>) -> T) -> Vec<T> {
        let mut values = Vec::new();
        for entry in self.entries.unwrap_or_default() {
            if self.known.borrow().iter().any(|known| *known == entry.key) {
                continue;
            }
            let path = self.at(&entry.key);
            self.check_id(&path, &entry.key);
            let entries = match &entry.node.value {
                Value::Table(entries) => Some(entries.as_slice()),
                other => {
                    self.wrong_type(&path, other, "a table");
                    None
                }
            };
            values.push(Self::read(self.report, path, entries, |section| {
                read(&entry.key, section)
            }));
        }
        // All of them are known now.
        self.known.borrow_mut().push("*");
        values
    }

    /// A required array of tables, at least one.
    pub(crate) fn list<T>(
        &self,
        key: &'static str,
        expected: &str,
        read: impl Fn(&Section<'a>) -> T,
    ) -> Vec<T> {
        let Some(node) = self.required(key, expected) else {
            return Vec::new();
        };
        let path = self.at(key);
        let Value::Array(items) = &node.value else {
            self.wrong_type(&path, &node.value, expected);
            return Vec::new();
        };
        if items.is_empty() {
            self.report.push(self.report.problem(
                ProblemKind::OutOfRange,
                &path,
                "an empty array",
                expected,
            ));
        }
        let mut values = Vec::with_capacity(items.len());
        for (index, item) in items.iter().enumerate() {
            let path = format!("{path}[{index}]");
            let entries = match &item.value {
                Value::Table(entries) => Some(entries.as_slice()),
                other => {
                    self.wrong_type(&path, other, "a table");
                    None
                }
            };
            values.push(Self::read(self.report, path, entries, &read));
        }
        values
    }

    /// A required name that can stand in keys, paths and network names.
    pub(crate) fn id(&self, key: &'static str, expected: &str) -> String {
        let id = self.text(key, expected);
        if !id.is_empty() {
            self.check_id(&self.at(key), &id);
        }
        id
    }

    fn check_id(&self, path: &str, id: &str) {
        const LONGEST: usize = 48;
        let good = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        if id.is_empty() || id.len() > LONGEST || !id.chars().all(good) {
            self.report.push(self.report.problem(
                ProblemKind::OutOfRange,
                path,
                format!("the name {id:?}"),
                format!("letters, digits, `-` and `_`, at most {LONGEST}"),
            ));
        }
    }

    /// Reports unknown keys, then the missing ones that no unknown key was meant for.
    fn finish(self) {
        let known = self.known.into_inner();
        let mut missing = self.missing.into_inner();
        let all_known = known.contains(&"*");
        for entry in self.entries.unwrap_or_default() {
            if all_known || known.iter().any(|key| *key == entry.key) {
                continue;
            }
            let written = |key: &str| {
                self.entries
                    .unwrap_or_default()
                    .iter()
                    .any(|entry| entry.key == key)
            };
            let free: Vec<&str> = known.iter().copied().filter(|key| !written(key)).collect();
            let place = if self.path.is_empty() {
                "at the top of the file".to_owned()
            } else {
                format!("in [{}]", self.path)
            };
            let mut problem = self.report.problem(
                ProblemKind::UnknownKey,
                &join(&self.path, &entry.key),
                format!("unknown key `{}`", entry.key),
                format!("a known key {place}: {}", hint::list(&known, "or")),
            );
            if let Some((meant, advice)) = hint::for_key(&entry.key, &free) {
                missing.retain(|(key, _)| *key != meant);
                problem = problem.with_hint(advice);
            }
            self.report.push(problem);
        }
        for (key, expected) in missing {
            let path = join(&self.path, key);
            self.report.push(self.report.problem(
                ProblemKind::MissingKey,
                &path,
                "nothing",
                expected,
            ));
        }
    }
}
