//! What is looked for in a page.

use super::super::whole::{self, LARGEST_BYTES};
use crate::record::Record;
use crate::report::specimens::check_body;

/// The page of a record, checked, and all of its texts.
pub(super) fn page(record: &Record) -> (String, Vec<String>) {
    let page = whole::html(record);
    let body = page
        .strip_prefix("<!DOCTYPE html>\n")
        .expect("it says what it is");
    let texts = check_body(body);
    for outside in [
        "http:", "https:", "src=", "<script", "@import", "url(h", "NaN", "inf ",
    ] {
        assert!(!page.contains(outside), "{outside}");
    }
    assert!(page.len() < LARGEST_BYTES, "{} bytes", page.len());
    (page, texts)
}

pub(super) fn count(page: &str, wanted: &str) -> usize {
    page.matches(wanted).count()
}

/// The drawing of a class.
pub(super) fn drawing<'a>(page: &'a str, class: &str) -> &'a str {
    let begin = page
        .find(&format!("<svg class=\"{class}\""))
        .expect("it is drawn");
    let end = page[begin..].find("</svg>").expect("it ends");
    &page[begin..begin + end]
}
