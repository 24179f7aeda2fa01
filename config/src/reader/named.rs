//! Sections whose keys are names that the file chooses.

use crate::reader::Section;
use crate::tree::{Node, Value};

impl<'a> Section<'a> {
    /// Every key not asked for so far, as a name with a text.
    pub(crate) fn each_text(&self, expected: &str) -> Vec<(String, String)> {
        self.each_named(|path, node| self.read_text(path, node, expected))
    }

    /// Every key not asked for so far, as a name with a list of texts.
    pub(crate) fn each_texts(&self, expected: &str) -> Vec<(String, Vec<String>)> {
        self.each_named(|path, node| {
            let Value::Array(items) = &node.value else {
                self.wrong_type(path, &node.value, &format!("an array: {expected}"));
                return Vec::new();
            };
            let text = |(index, item)| self.read_text(&format!("{path}[{index}]"), item, expected);
            items.iter().enumerate().map(text).collect()
        })
    }

    fn each_named<T>(&self, read: impl Fn(&str, &'a Node) -> T) -> Vec<(String, T)> {
        let mut values = Vec::new();
        for entry in self.entries.unwrap_or_default() {
            if self.known.borrow().iter().any(|known| *known == entry.key) {
                continue;
            }
            let path = self.at(&entry.key);
            self.check_id(&path, &entry.key);
            values.push((entry.key.clone(), read(&path, &entry.node)));
        }
        // All of them are known now.
        self.known.borrow_mut().push("*");
        values
    }
}
