//! The rules that single values follow.

use std::path::PathBuf;
use std::time::Duration;

use super::error::KeyError;
use super::field::{Field, Section};
use super::page::Page;
use super::quantity::{Count, Quantity};
use super::source::{Fault, Need, Source};

/// The table's own name: it is no key.
pub struct Name;
/// `true` or `false`.
pub struct Truth;
/// One line of text; says what is expected.
pub struct Text(pub &'static str);
/// A name that can stand in keys, paths and network names; says what is expected.
pub struct Id(pub &'static str);
/// A list of texts, empty when left out; says what each is.
pub struct Texts(pub &'static str);
/// One of a few words.
pub struct Word;
/// A list of words, and whether it must be written.
pub struct WordList(pub Need);
/// A value that may be left out.
pub struct Optional<R>(pub R);
/// The keys of a section that stand in the table around it.
pub struct Flat;
/// A table `{ x_m = …, y_m = …, theta_rad = … }`.
pub struct Pose(pub Quantity);
/// A table `{ min_m = [x, y], max_m = [x, y] }`.
pub struct Corners(pub Quantity);
/// The keys `from_m` and `to_m`, in the table around it.
pub struct Ends(pub Quantity);
/// A duration that the file gives in whole microseconds.
pub struct Micros(pub Count);
/// A duration that the file gives in whole milliseconds.
pub struct Millis(pub Count);

/// Words that stand for choices; made by [`words!`](crate::words).
pub trait Words: Copy {
    /// All of them.
    const WORDS: &'static [&'static str];
    /// What the word stands for; the first choice for any other word.
    fn of(word: &str) -> Self;
    /// The word that stands for it.
    fn word(self) -> &'static str;
}

/// "`a`, `b` or `c`", cut off when there are many.
#[must_use]
pub fn quoted_list(names: &[&str], last: &str) -> String {
    const SHOWN: usize = 16;
    let mut quoted: Vec<String> = names
        .iter()
        .take(SHOWN)
        .map(|name| format!("`{name}`"))
        .collect();
    if names.len() > SHOWN {
        quoted.push(format!("{} more", names.len() - SHOWN));
    }
    match quoted.pop() {
        None => String::new(),
        Some(only) if quoted.is_empty() => only,
        Some(end) => format!("{} {last} {end}", quoted.join(", ")),
    }
}

fn need<T>(default: &Option<T>) -> Need {
    match default {
        Some(_) => Need::Optional,
        None => Need::Required,
    }
}

/// What the page shows for a value that may be left out, and is then none.
pub(crate) fn none() -> Option<String> {
    Some("none".to_owned())
}

impl Field<Quantity> for f64 {
    fn read(s: &dyn Source, key: &'static str, rule: &Quantity, default: Option<f64>) -> f64 {
        let read = s.number(key, rule, need(&default));
        read.or(default).unwrap_or(f64::NAN)
    }

    fn check(&self, key: &str, rule: &Quantity) -> Result<(), KeyError> {
        if rule.holds(*self) {
            return Ok(());
        }
        Err(KeyError::new(key, format!("{self:?}"), rule.describe()))
    }

    fn document(
        page: &mut Page,
        key: &'static str,
        rule: &Quantity,
        default: Option<f64>,
        about: &'static str,
    ) {
        let default = default.map(|value| format!("{:?}", super::rounded(value)));
        page.key(key, rule.describe(), default, about);
    }
}

impl Field<Optional<Quantity>> for Option<f64> {
    fn read(s: &dyn Source, key: &'static str, rule: &Optional<Quantity>, _: Option<Self>) -> Self {
        s.number(key, &rule.0, Need::Optional)
    }

    fn check(&self, key: &str, rule: &Optional<Quantity>) -> Result<(), KeyError> {
        self.map_or(Ok(()), |value| value.check(key, &rule.0))
    }

    fn document(
        page: &mut Page,
        key: &'static str,
        rule: &Optional<Quantity>,
        _: Option<Self>,
        about: &'static str,
    ) {
        page.key(key, rule.0.describe(), none(), about);
    }
}

impl Field<Count> for u32 {
    fn read(s: &dyn Source, key: &'static str, rule: &Count, default: Option<u32>) -> u32 {
        let read = s.count(key, rule, need(&default));
        read.or(default).unwrap_or_default()
    }

    fn check(&self, key: &str, rule: &Count) -> Result<(), KeyError> {
        if rule.holds(i64::from(*self)) {
            return Ok(());
        }
        Err(KeyError::new(key, self.to_string(), rule.describe()))
    }

    fn document(
        page: &mut Page,
        key: &'static str,
        rule: &Count,
        default: Option<u32>,
        about: &'static str,
    ) {
        page.key(
            key,
            rule.describe(),
            default.map(|value| value.to_string()),
            about,
        );
    }
}

impl Field<Count> for Vec<u32> {
    fn read(s: &dyn Source, key: &'static str, rule: &Count, default: Option<Self>) -> Self {
        s.counts(key, rule, need(&default))
            .or(default)
            .unwrap_or_default()
    }

    fn check(&self, key: &str, rule: &Count) -> Result<(), KeyError> {
        self.iter().try_for_each(|value| value.check(key, rule))
    }

    fn document(
        page: &mut Page,
        key: &'static str,
        rule: &Count,
        default: Option<Self>,
        about: &'static str,
    ) {
        let value = format!("an array of {}", rule.describe());
        page.key(key, value, default.map(|value| format!("{value:?}")), about);
    }
}

/// A duration in whole parts of a second.
macro_rules! duration {
    ($rule:ident, $from:ident, $as:ident) => {
        impl Field<$rule> for Duration {
            fn read(
                s: &dyn Source,
                key: &'static str,
                rule: &$rule,
                default: Option<Self>,
            ) -> Self {
                let read = s.count(key, &rule.0, need(&default));
                let read = read.map(|value| Duration::$from(value.into()));
                read.or(default).unwrap_or_default()
            }

            fn check(&self, key: &str, rule: &$rule) -> Result<(), KeyError> {
                u32::try_from(self.$as())
                    .unwrap_or(u32::MAX)
                    .check(key, &rule.0)
            }

            fn document(
                page: &mut Page,
                key: &'static str,
                rule: &$rule,
                default: Option<Self>,
                about: &'static str,
            ) {
                let default = default.map(|value| value.$as().to_string());
                page.key(key, rule.0.describe(), default, about);
            }
        }
    };
}
duration!(Micros, from_micros, as_micros);
duration!(Millis, from_millis, as_millis);

impl Field<Truth> for bool {
    fn read(s: &dyn Source, key: &'static str, _: &Truth, default: Option<bool>) -> bool {
        s.truth(key, need(&default)).or(default).unwrap_or_default()
    }

    fn document(
        page: &mut Page,
        key: &'static str,
        _: &Truth,
        default: Option<bool>,
        about: &'static str,
    ) {
        page.key(
            key,
            "true or false",
            default.map(|value| value.to_string()),
            about,
        );
    }
}

impl Field<Name> for String {
    fn read(s: &dyn Source, _: &'static str, _: &Name, _: Option<String>) -> String {
        s.name().to_owned()
    }

    fn document(_: &mut Page, _: &'static str, _: &Name, _: Option<String>, _: &'static str) {}
}

impl Field<Id> for String {
    fn read(s: &dyn Source, key: &'static str, rule: &Id, _: Option<String>) -> String {
        s.id(key, rule.0)
    }

    fn document(
        page: &mut Page,
        key: &'static str,
        rule: &Id,
        _: Option<String>,
        about: &'static str,
    ) {
        page.key(key, rule.0, None, about);
    }
}

impl Field<Text> for String {
    fn read(s: &dyn Source, key: &'static str, rule: &Text, default: Option<String>) -> String {
        let read = s.text(key, rule.0, need(&default));
        read.or(default).unwrap_or_default()
    }

    fn document(
        page: &mut Page,
        key: &'static str,
        rule: &Text,
        default: Option<String>,
        about: &'static str,
    ) {
        page.key(
            key,
            rule.0,
            default.map(|value| format!("{value:?}")),
            about,
        );
    }
}

impl Field<Optional<Text>> for Option<String> {
    fn read(s: &dyn Source, key: &'static str, rule: &Optional<Text>, _: Option<Self>) -> Self {
        s.text(key, rule.0.0, Need::Optional)
    }

    fn document(
        page: &mut Page,
        key: &'static str,
        rule: &Optional<Text>,
        _: Option<Self>,
        about: &'static str,
    ) {
        page.key(key, rule.0.0, none(), about);
    }
}

impl Field<Text> for PathBuf {
    fn read(s: &dyn Source, key: &'static str, rule: &Text, _: Option<Self>) -> Self {
        let path = s.text(key, rule.0, Need::Required).unwrap_or_default();
        if !path.is_empty() && !path.starts_with('/') {
            let found = format!("text {path:?}");
            s.refuse(Fault::OutOfRange, key, found, "an absolute path".to_owned());
        }
        PathBuf::from(path)
    }

    fn document(
        page: &mut Page,
        key: &'static str,
        rule: &Text,
        _: Option<Self>,
        about: &'static str,
    ) {
        page.key(key, rule.0, None, about);
    }
}

impl Field<Texts> for Vec<String> {
    fn read(s: &dyn Source, key: &'static str, rule: &Texts, _: Option<Self>) -> Self {
        s.texts(key, rule.0)
    }

    fn document(
        page: &mut Page,
        key: &'static str,
        rule: &Texts,
        _: Option<Self>,
        about: &'static str,
    ) {
        page.key(key, format!("an array: {}", rule.0), none(), about);
    }
}

impl<T: Words> Field<Word> for T {
    fn read(s: &dyn Source, key: &'static str, _: &Word, default: Option<T>) -> T {
        let read = s.word(key, T::WORDS, need(&default)).map(T::of);
        read.or(default).unwrap_or_else(|| T::of(""))
    }

    fn document(
        page: &mut Page,
        key: &'static str,
        _: &Word,
        default: Option<T>,
        about: &'static str,
    ) {
        let default = default.map(|value| format!("{:?}", value.word()));
        page.key(key, quoted_list(T::WORDS, "or"), default, about);
    }
}

impl<T: Words> Field<WordList> for Vec<T> {
    fn read(s: &dyn Source, key: &'static str, rule: &WordList, _: Option<Self>) -> Self {
        s.words(key, T::WORDS, rule.0)
            .into_iter()
            .map(T::of)
            .collect()
    }

    fn document(
        page: &mut Page,
        key: &'static str,
        rule: &WordList,
        _: Option<Self>,
        about: &'static str,
    ) {
        let value = format!("an array of {}", quoted_list(T::WORDS, "or"));
        let default = (rule.0 == Need::Optional).then(|| "none".to_owned());
        page.key(key, value, default, about);
    }
}

impl<T: Section> Field<Flat> for T {
    fn read(s: &dyn Source, _: &'static str, _: &Flat, _: Option<T>) -> T {
        T::read(s)
    }

    fn check(&self, _: &str, _: &Flat) -> Result<(), KeyError> {
        Section::check(self)
    }

    fn excuse(s: &dyn Source, _: &'static str, _: &Flat) {
        T::excuse(s);
    }

    fn document(page: &mut Page, _: &'static str, _: &Flat, _: Option<T>, _: &'static str) {
        T::document(page);
    }
}
