//! The rules for tables within tables.

use std::collections::BTreeMap;

use super::error::KeyError;
use super::field::{Field, Section};
use super::page::Page;
use super::rules::Optional;
use super::source::{Need, Source};

/// A table that must be there; says what is expected.
pub struct Table(pub &'static str);
/// A table that may be left out: then all of its keys have their defaults.
pub struct TableOrDefaults;
/// Every key of the table around it that is not its own, as a table that the file names; says by what.
pub struct Each(pub &'static str);
/// A table whose keys are names that the file chooses; says what is expected.
pub struct Map(pub &'static str, pub Need);
/// An array of tables; says what is expected.
pub struct List(pub &'static str, pub Need);

impl<T: Section> Field<Table> for T {
    fn read(s: &dyn Source, key: &'static str, rule: &Table, _: Option<T>) -> T {
        table(s, key, rule.0, Need::Required)
    }

    fn check(&self, key: &str, _: &Table) -> Result<(), KeyError> {
        Section::check(self).map_err(|error| error.below(key))
    }

    fn document(page: &mut Page, key: &'static str, _: &Table, _: Option<T>, _: &'static str) {
        page.table(key, T::ABOUT, T::document);
    }
}

impl<T: Section> Field<TableOrDefaults> for T {
    fn read(s: &dyn Source, key: &'static str, _: &TableOrDefaults, _: Option<T>) -> T {
        table(s, key, "a table", Need::Optional)
    }

    fn check(&self, key: &str, _: &TableOrDefaults) -> Result<(), KeyError> {
        Section::check(self).map_err(|error| error.below(key))
    }

    fn document(
        page: &mut Page,
        key: &'static str,
        _: &TableOrDefaults,
        _: Option<T>,
        _: &'static str,
    ) {
        page.table(key, T::ABOUT, T::document);
    }
}

impl<T: Section> Field<Optional<Table>> for Option<T> {
    fn read(s: &dyn Source, key: &'static str, rule: &Optional<Table>, _: Option<Self>) -> Self {
        s.has(key).then(|| table(s, key, rule.0.0, Need::Required))
    }

    fn check(&self, key: &str, rule: &Optional<Table>) -> Result<(), KeyError> {
        self.as_ref()
            .map_or(Ok(()), |table| Field::<Table>::check(table, key, &rule.0))
    }

    fn document(
        page: &mut Page,
        key: &'static str,
        _: &Optional<Table>,
        _: Option<Self>,
        _: &'static str,
    ) {
        page.table(key, T::ABOUT, T::document);
    }
}

fn table<T: Section>(s: &dyn Source, key: &'static str, expected: &str, need: Need) -> T {
    let mut value = None;
    s.table(key, expected, need, &mut |s| value = Some(T::read(s)));
    value.unwrap_or_else(|| T::read(s))
}

impl<T: Section> Field<Each> for Vec<T> {
    fn read(s: &dyn Source, _: &'static str, _: &Each, _: Option<Self>) -> Self {
        let mut values = Vec::new();
        s.each(&mut |s| values.push(T::read(s)));
        values
    }

    fn check(&self, key: &str, _: &Each) -> Result<(), KeyError> {
        self.iter()
            .try_for_each(|value| Section::check(value).map_err(|error| error.below(key)))
    }

    fn document(page: &mut Page, _: &'static str, rule: &Each, _: Option<Self>, _: &'static str) {
        page.table(rule.0, T::ABOUT, T::document);
    }
}

impl<T: Section> Field<Map> for Vec<T> {
    fn read(s: &dyn Source, key: &'static str, rule: &Map, _: Option<Self>) -> Self {
        let mut values = Vec::new();
        s.table(key, rule.0, rule.1, &mut |s| {
            s.each(&mut |s| values.push(T::read(s)))
        });
        values
    }

    fn check(&self, key: &str, _: &Map) -> Result<(), KeyError> {
        self.iter()
            .try_for_each(|value| Section::check(value).map_err(|error| error.below(key)))
    }

    fn document(page: &mut Page, key: &'static str, _: &Map, _: Option<Self>, _: &'static str) {
        page.table(key, "", |page| page.table("<id>", T::ABOUT, T::document));
    }
}

impl<T: Section> Field<Map> for BTreeMap<String, T> {
    fn read(s: &dyn Source, key: &'static str, rule: &Map, _: Option<Self>) -> Self {
        let mut values = Self::new();
        s.table(key, rule.0, rule.1, &mut |s| values = each(s));
        values
    }

    fn check(&self, key: &str, _: &Map) -> Result<(), KeyError> {
        self.iter().try_for_each(|(name, value)| {
            Section::check(value).map_err(|error| error.below(name).below(key))
        })
    }

    fn document(page: &mut Page, key: &'static str, _: &Map, _: Option<Self>, _: &'static str) {
        page.table(key, "", |page| page.table("<id>", T::ABOUT, T::document));
    }
}

fn each<T: Section>(s: &dyn Source) -> BTreeMap<String, T> {
    let mut values = BTreeMap::new();
    s.each(&mut |s| {
        values.insert(s.name().to_owned(), T::read(s));
    });
    values
}

/// Names within names: `[flags.<role>.<flag>]`.
impl<T: Section> Field<Map> for BTreeMap<String, BTreeMap<String, T>> {
    fn read(s: &dyn Source, key: &'static str, rule: &Map, _: Option<Self>) -> Self {
        let mut values = Self::new();
        s.table(key, rule.0, rule.1, &mut |s| {
            s.each(&mut |s| {
                values.insert(s.name().to_owned(), each(s));
            });
        });
        values
    }

    fn document(page: &mut Page, key: &'static str, _: &Map, _: Option<Self>, _: &'static str) {
        page.table(key, "", |page| {
            page.table("<id>", "", |page| page.table("<id>", T::ABOUT, T::document));
        });
    }
}

/// The table itself is the map.
impl<T: Section> Field<Each> for BTreeMap<String, T> {
    fn read(s: &dyn Source, _: &'static str, _: &Each, _: Option<Self>) -> Self {
        each(s)
    }

    fn document(page: &mut Page, _: &'static str, rule: &Each, _: Option<Self>, _: &'static str) {
        page.table(rule.0, T::ABOUT, T::document);
    }
}

impl<T: Section> Field<List> for Vec<T> {
    fn read(s: &dyn Source, key: &'static str, rule: &List, _: Option<Self>) -> Self {
        let mut values = Vec::new();
        let expected = format!("an array of {}", rule.0);
        s.list(key, &expected, rule.1, &mut |s| values.push(T::read(s)));
        values
    }

    fn check(&self, key: &str, _: &List) -> Result<(), KeyError> {
        for (index, value) in self.iter().enumerate() {
            Section::check(value).map_err(|error| error.below(&format!("{key}[{index}]")))?;
        }
        Ok(())
    }

    fn document(
        page: &mut Page,
        key: &'static str,
        rule: &List,
        _: Option<Self>,
        about: &'static str,
    ) {
        let default = (rule.1 == Need::Optional).then(|| "none".to_owned());
        page.key(key, format!("an array of {}", rule.0), default, about);
        page.table(&format!("{key}[]"), T::ABOUT, T::document);
    }
}
