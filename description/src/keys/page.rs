//! The reference page of all keys, as data.

use std::fmt::Write as _;

/// One key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyDoc {
    /// The key in its table.
    pub key: String,
    /// What may be written.
    pub value: String,
    /// What holds when it is left out; `None`: it must be written.
    pub default: Option<String>,
    /// What it means.
    pub about: String,
}

/// One table.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TableDoc {
    /// Its path, such as `drive` or `areas.<id>`; empty: the top of the file.
    pub path: String,
    /// What it is.
    pub about: String,
    /// Its keys.
    pub keys: Vec<KeyDoc>,
}

/// All tables of a file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Page {
    /// In the order of their declaration.
    pub tables: Vec<TableDoc>,
    current: usize,
}

impl Page {
    /// Adds a key to the current table.
    pub fn key(
        &mut self,
        key: &str,
        value: impl Into<String>,
        default: Option<String>,
        about: &str,
    ) {
        if let Some(table) = self.tables.get_mut(self.current) {
            table.keys.push(KeyDoc {
                key: key.to_owned(),
                value: value.into(),
                default,
                about: about.trim().to_owned(),
            });
        }
    }

    /// Adds a table below the current one.
    pub fn table(&mut self, key: &str, about: &str, write: impl FnOnce(&mut Self)) {
        let outer = self
            .tables
            .get(self.current)
            .map_or("", |t| t.path.as_str());
        let dot = if outer.is_empty() || key.is_empty() {
            ""
        } else {
            "."
        };
        let table = TableDoc {
            path: format!("{outer}{dot}{key}"),
            about: about.trim().to_owned(),
            keys: Vec::new(),
        };
        let before = self.current;
        self.current = self.tables.len();
        self.tables.push(table);
        write(self);
        self.current = before;
    }

    /// The page in Markdown: a heading and a table of keys for each table of the file.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut text = String::new();
        // Keys begin in lines of their own; a bar would end a cell, and `<id>` would be a tag.
        let cell = |text: &str| {
            let text = text.replace('\n', " ").replace('|', "\\|");
            // Between backticks it is shown as it is.
            let mut code = true;
            let parts = text.split('`').map(|part| {
                code = !code;
                if code {
                    part.to_owned()
                } else {
                    part.replace('<', "&lt;")
                }
            });
            parts.collect::<Vec<_>>().join("`")
        };
        for table in self.tables.iter().filter(|table| !table.keys.is_empty()) {
            let title = match table.path.as_str() {
                "" => "At the top".to_owned(),
                path => format!("`[{path}]`"),
            };
            let _ = write!(text, "\n### {title}\n\n{}\n\n", cell(&table.about));
            text.push_str("| key | value | default | meaning |\n|---|---|---|---|\n");
            for key in &table.keys {
                let default = key.default.as_deref().unwrap_or("**required**");
                let (name, value, about) = (&key.key, cell(&key.value), cell(&key.about));
                let _ = writeln!(text, "| `{name}` | {value} | {} | {about} |", cell(default));
            }
        }
        text
    }
}
