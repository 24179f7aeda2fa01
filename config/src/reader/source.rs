//! A table of the file as a source of values.

use description::keys::{Count, Fault, Need, Quantity, Source, quoted_list};

use super::section::Section;
use crate::diagnostic::ProblemKind;
use crate::node::Value;

impl Source for Section<'_> {
    fn name(&self) -> &str {
        self.path.rsplit('.').next().unwrap_or_default()
    }

    fn has(&self, key: &'static str) -> bool {
        self.find(key, Need::Optional, String::new).is_some()
    }

    fn number(&self, key: &'static str, quantity: &Quantity, need: Need) -> Option<f64> {
        let node = self.find(key, need, || quantity.describe())?;
        Some(self.read_number(&self.at(key), node, quantity))
    }

    fn count(&self, key: &'static str, count: &Count, need: Need) -> Option<u32> {
        let node = self.find(key, need, || count.describe())?;
        Some(self.read_count(&self.at(key), node, count))
    }

    fn counts(&self, key: &'static str, count: &Count, need: Need) -> Option<Vec<u32>> {
        let expected = format!("an array of {}", count.describe());
        let node = self.find(key, need, || expected.clone())?;
        let items = self.some_items(&self.at(key), node, &expected);
        let read = items
            .iter()
            .map(|(path, item)| self.read_count(path, item, count));
        Some(read.collect())
    }

    fn truth(&self, key: &'static str, need: Need) -> Option<bool> {
        const EXPECTED: &str = "true or false";
        let node = self.find(key, need, || EXPECTED.to_owned())?;
        if let Value::Boolean(truth) = node.value {
            return Some(truth);
        }
        self.wrong_type(&self.at(key), &node.value, EXPECTED);
        Some(false)
    }

    fn text(&self, key: &'static str, expected: &str, need: Need) -> Option<String> {
        let node = self.find(key, need, || expected.to_owned())?;
        Some(self.read_text(&self.at(key), node, expected))
    }

    fn id(&self, key: &'static str, expected: &str) -> String {
        let id = self.text(key, expected, Need::Required).unwrap_or_default();
        if !id.is_empty() {
            self.check_id(&self.at(key), &id);
        }
        id
    }

    fn texts(&self, key: &'static str, expected: &str) -> Vec<String> {
        let Some(node) = self.find(key, Need::Optional, String::new) else {
            return Vec::new();
        };
        let items = self.items(&self.at(key), node, &format!("an array: {expected}"));
        let read = items
            .iter()
            .map(|(path, item)| self.read_text(path, item, expected));
        read.collect()
    }

    fn word(&self, key: &'static str, words: &[&'static str], need: Need) -> Option<&'static str> {
        let node = self.find(key, need, || quoted_list(words, "or"))?;
        self.read_word(&self.at(key), node, words)
    }

    fn words(&self, key: &'static str, words: &[&'static str], need: Need) -> Vec<&'static str> {
        let expected = format!("an array of {}", quoted_list(words, "or"));
        let Some(node) = self.find(key, need, || expected.clone()) else {
            return Vec::new();
        };
        let items = self.items(&self.at(key), node, &expected);
        let read = items
            .iter()
            .filter_map(|(path, item)| self.read_word(path, item, words));
        read.collect()
    }

    fn word_or_number(
        &self,
        key: &'static str,
        words: &[&'static str],
        most: u32,
        expected: &str,
    ) -> Option<Result<&'static str, u32>> {
        let node = self.find(key, Need::Required, || expected.to_owned())?;
        let value = match &node.value {
            Value::Text(text) => words
                .iter()
                .find(|word| *word == text)
                .map(|word| Ok(*word)),
            Value::Integer(number) => u32::try_from(*number)
                .ok()
                .filter(|number| *number <= most)
                .map(Err),
            _ => None,
        };
        if value.is_none() {
            self.neither(key, &node.value, expected);
        }
        value
    }

    fn one_of(&self, key: &'static str, numbers: &[u32], expected: &str) -> u32 {
        let Some(node) = self.find(key, Need::Required, || expected.to_owned()) else {
            return 0;
        };
        let read = match node.value {
            Value::Integer(number) => numbers.iter().find(|one| i64::from(**one) == number),
            _ => None,
        };
        if read.is_none() {
            self.neither(key, &node.value, expected);
        }
        read.copied().unwrap_or_default()
    }

    fn point(&self, key: &'static str, quantity: &Quantity) -> [f64; 2] {
        let expected = format!("[x, y], each {}", quantity.describe());
        let Some(node) = self.find(key, Need::Required, || expected.clone()) else {
            return [f64::NAN; 2];
        };
        let path = self.at(key);
        let number =
            |axis: usize, item| self.read_number(&format!("{path}[{axis}]"), item, quantity);
        match &node.value {
            Value::Array(items) if items.len() == 2 => [number(0, &items[0]), number(1, &items[1])],
            other => {
                self.wrong_type(&path, other, &expected);
                [f64::NAN; 2]
            }
        }
    }

    fn table(
        &self,
        key: &'static str,
        expected: &str,
        need: Need,
        read: &mut dyn FnMut(&dyn Source),
    ) {
        let node = self.find(key, need, || expected.to_owned());
        let path = self.at(key);
        let entries = node.and_then(|node| self.entries_of(&path, &node.value, expected));
        Self::read(self.report, path, entries, read);
    }

    fn list(
        &self,
        key: &'static str,
        expected: &str,
        need: Need,
        read: &mut dyn FnMut(&dyn Source),
    ) {
        let Some(node) = self.find(key, need, || expected.to_owned()) else {
            return;
        };
        for (path, item) in self.some_items(&self.at(key), node, expected) {
            let entries = self.entries_of(&path, &item.value, "a table");
            Self::read(self.report, path, entries, &mut *read);
        }
    }

    fn each(&self, read: &mut dyn FnMut(&dyn Source)) {
        for entry in self.take_rest() {
            let path = self.at(&entry.key);
            self.check_id(&path, &entry.key);
            let entries = self.entries_of(&path, &entry.node.value, "a table");
            Self::read(self.report, path, entries, &mut *read);
        }
    }

    fn each_text(&self, expected: &str) -> Vec<(String, String)> {
        self.each_named(|path, node| self.read_text(path, node, expected))
    }

    fn each_texts(&self, expected: &str) -> Vec<(String, Vec<String>)> {
        self.each_named(|path, node| {
            let items = self.items(path, node, &format!("an array: {expected}"));
            let read = items
                .iter()
                .map(|(path, item)| self.read_text(path, item, expected));
            read.collect()
        })
    }

    fn refuse(&self, fault: Fault, key: &str, found: String, expected: String) {
        // An absent table has already been reported as a whole.
        if self.entries.is_none() {
            return;
        }
        let kind = match fault {
            Fault::Missing => ProblemKind::MissingKey,
            Fault::OutOfRange => ProblemKind::OutOfRange,
            Fault::Inconsistent => ProblemKind::Inconsistent,
        };
        self.report.wrong(kind, &self.at(key), found, expected);
    }
}

impl Section<'_> {
    /// Reports a value that is neither a known word nor a number in range.
    fn neither(&self, key: &str, value: &Value, expected: &str) {
        let kind = match value {
            Value::Text(_) | Value::Integer(_) | Value::HugeInteger(_) => ProblemKind::OutOfRange,
            _ => ProblemKind::WrongType,
        };
        self.report
            .wrong(kind, &self.at(key), value.show(), expected);
    }
}
