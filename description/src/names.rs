//! Names on the network: the one rule for the file that says a name and for the key that is built of it.

/// Whether a text can be one part of a key: letters, digits, `-`, `_` and `.`, at least one.
#[must_use]
pub fn is_key_part(text: &str) -> bool {
    let good = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'-' | b'_' | b'.');
    !text.is_empty() && text.bytes().all(good)
}

/// Whether a text can begin all keys: parts between single `/`.
#[must_use]
pub fn is_key_prefix(text: &str) -> bool {
    text.split('/').all(is_key_part)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_plain_names_between_single_slashes() {
        assert!(is_key_prefix("hall/a-1/test_2.x"));
        for bad in ["", "/a", "a/", "a//b", "halle:1", "a b", "*", "$*", "ä"] {
            assert!(!is_key_prefix(bad), "{bad:?}");
        }
        assert!(!is_key_part("a/b"));
    }
}
