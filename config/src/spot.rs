//! Places in texts that values come from.

use std::ops::Range;
use std::sync::Arc;

use miette::NamedSource;

/// A text that values come from: the file, or one `--set`.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    pub(crate) text: Arc<NamedSource<String>>,
    /// A `--set` has no lines worth naming.
    pub(crate) is_file: bool,
}

/// A stretch of a source.
#[derive(Clone, Debug)]
pub(crate) struct Spot {
    pub(crate) source: usize,
    pub(crate) span: Range<usize>,
}

/// `outer.key`, or `key` at the top.
pub(crate) fn join(outer: &str, key: &str) -> String {
    if outer.is_empty() {
        key.to_owned()
    } else {
        format!("{outer}.{key}")
    }
}

/// The 1-based line of a byte offset.
pub(crate) fn line_of(text: &str, offset: usize) -> usize {
    let end = offset.min(text.len());
    1 + text.as_bytes()[..end]
        .iter()
        .filter(|&&byte| byte == b'\n')
        .count()
}
