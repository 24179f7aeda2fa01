//! Names for a message, no more of them than one reads.

use alloc::string::String;
use core::fmt::Write;

const SHOWN: usize = 12;

/// "a, b and 3 more", so that each of many errors can say what is known.
pub(crate) fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let (mut text, mut more) = (String::new(), 0_usize);
    for (index, name) in names.into_iter().enumerate() {
        if index >= SHOWN {
            more += 1;
            continue;
        }
        if index > 0 {
            text.push_str(", ");
        }
        text.push_str(name);
    }
    if more > 0 {
        // A string takes all text.
        let _ = write!(text, " and {more} more");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_list_ends_with_a_number() {
        assert_eq!(listed([]), "");
        assert_eq!(listed(["a", "b"]), "a, b");
        assert_eq!(listed(["a"; 12]).matches('a').count(), 12);
        assert_eq!(
            listed(["b"; 15]),
            "b, b, b, b, b, b, b, b, b, b, b, b and 3 more"
        );
    }
}
