//! Numbers of 128 bits: a processor of 32 bits takes many instructions for each, in line, so that nothing in a program tells of them.
//! What runs on the board has none, but for those that are named here with what they are for.

use std::path::Path;

use crate::files::{ReadError, read};
use crate::source::child_file;

/// Crates of which the board's programs are made.
const CRATES: [&str; 8] = [
    "config",
    "contract",
    "coordination",
    "description",
    "drivers",
    "mediator",
    "onboard",
    "skills",
];
const WIDE: [&str; 2] = ["i128", "u128"];

/// Added up while a net is proved, before anything runs.
const COUNTS: &str = "numbers of states and steps, of which diagrams find more than 2^64";
/// Where they are needed, by how the path begins, and for what.
const NEEDED: [(&str, &str); 5] = [
    ("coordination/src/analysis/check.rs", COUNTS),
    ("coordination/src/analysis/findings.rs", COUNTS),
    ("coordination/src/analysis/properties.rs", COUNTS),
    ("coordination/src/analysis/report.rs", COUNTS),
    ("coordination/src/analysis/symbolic/", COUNTS),
];

/// How an item begins that is for tests alone.
const FOR_TESTS: [&[&str]; 3] = [
    &["#", "[", "test", "]"],
    &["#", "[", "cfg", "(", "test", ")"],
    &["#", "[", "cfg", "(", "all", "(", "test"],
];

/// A file, from the workspace's root, and a line in it.
type Use = (String, usize);
/// A line, and a word or a sign on it.
type Token<'a> = (usize, &'a str);

/// Every line with such a number, and every exception that is none any more.
///
/// # Errors
/// [`ReadError::File`].
pub fn findings(root: &Path) -> Result<Vec<String>, ReadError> {
    let mut uses = Vec::new();
    for name in CRATES {
        let folder = root.join(name).join("src");
        for entry in ["lib.rs", "main.rs"] {
            let entry = folder.join(entry);
            if entry.is_file() {
                uses.extend(uses_below(root, &entry, &folder)?);
            }
        }
    }
    Ok(judged(&uses))
}

fn judged(uses: &[Use]) -> Vec<String> {
    let mut findings = Vec::new();
    for (path, line) in uses {
        if !NEEDED.iter().any(|(needed, _)| path.starts_with(needed)) {
            findings.push(format!(
                "{path}:{line}: a number of 128 bits; compute with 64, or say in xtask/src/wide.rs what it is for"
            ));
        }
    }
    for (needed, what) in NEEDED {
        if !uses.iter().any(|(path, _)| path.starts_with(needed)) {
            findings.push(format!(
                "xtask/src/wide.rs: there is no number of 128 bits in {needed} any more ({what})"
            ));
        }
    }
    findings
}

/// Those of a module's file and of its children; `folder` is that of the children.
fn uses_below(root: &Path, file: &Path, folder: &Path) -> Result<Vec<Use>, ReadError> {
    let text = read(file)?;
    let tokens = without_tests(&tokens(&text));
    let path = file.strip_prefix(root).unwrap_or(file).display();
    let mut uses: Vec<Use> = { lines(&tokens).into_iter() }
        .map(|line| (path.to_string(), line))
        .collect();
    for declared in tokens.windows(3) {
        if let [(_, "mod"), (_, name), (_, ";")] = declared {
            let (file, inside) = child_file(folder, name);
            uses.extend(uses_below(root, &file, &inside)?);
        }
    }
    Ok(uses)
}

/// The lines that name a type of 128 bits, each once.
fn lines(tokens: &[Token<'_>]) -> Vec<usize> {
    let wide = tokens.iter().filter(|(_, word)| is_wide(word));
    let mut lines: Vec<usize> = wide.map(|(line, _)| *line).collect();
    lines.dedup();
    lines
}

/// The type itself, or a number with it behind.
fn is_wide(word: &str) -> bool {
    WIDE.iter()
        .filter_map(|wide| word.strip_suffix(wide))
        .any(|number| number.chars().next().is_none_or(char::is_numeric))
}

fn without_tests<'a>(tokens: &[Token<'a>]) -> Vec<Token<'a>> {
    let (mut own, mut rest) = (Vec::new(), tokens);
    while let Some((first, behind)) = rest.split_first() {
        let begins_with = |beginning: &&[&str]| {
            let words = rest.iter().map(|(_, word)| *word);
            words.take(beginning.len()).eq(beginning.iter().copied())
        };
        if FOR_TESTS.iter().any(begins_with) {
            rest = &rest[item(rest)..];
        } else {
            own.push(*first);
            rest = behind;
        }
    }
    own
}

/// How many tokens an item has, from its attributes to its last brace or semicolon.
fn item(tokens: &[Token<'_>]) -> usize {
    let mut depth = 0;
    for (at, (_, word)) in tokens.iter().enumerate() {
        match *word {
            "(" | "[" | "{" => depth += 1,
            // Of what it stands in.
            ")" | "]" | "}" if depth == 0 => return at,
            "}" if depth == 1 => return at + 1,
            ")" | "]" | "}" => depth -= 1,
            ";" if depth == 0 => return at + 1,
            _ => {}
        }
    }
    tokens.len()
}

/// All that is neither blank nor a comment, a string or a character.
fn tokens(text: &str) -> Vec<Token<'_>> {
    let (mut tokens, mut line, mut rest) = (Vec::new(), 1, text);
    while let Some(first) = rest.chars().next() {
        let mut length = skipped(rest);
        if length == 0 {
            length = word(rest).max(first.len_utf8());
            tokens.push((line, &rest[..length]));
        }
        line += rest[..length].matches('\n').count();
        rest = &rest[length..];
    }
    tokens
}

/// How long the word is that a text begins with.
fn word(text: &str) -> usize {
    let end = text.find(|one: char| !one.is_alphanumeric() && one != '_');
    end.unwrap_or(text.len())
}

/// How long the blanks, the comment, the string or the character is that a text begins with.
fn skipped(text: &str) -> usize {
    let word = word(text);
    let behind = &text[word..];
    let hashes = behind.len() - behind.trim_start_matches('#').len();
    let is_string = behind[hashes..].starts_with('"');
    match &text[..word] {
        "r" | "br" | "cr" if is_string => word + raw(behind, hashes),
        "" | "b" | "c" if behind.starts_with('"') => word + quoted(behind, '"'),
        "" | "b" if is_character(behind) => word + quoted(behind, '\''),
        "" if text.starts_with("//") => text.find('\n').unwrap_or(text.len()),
        "" if text.starts_with("/*") => comment(text),
        "" => text.len() - text.trim_start().len(),
        _ => 0,
    }
}

/// A string without escapes, from its hashes on.
fn raw(text: &str, hashes: usize) -> usize {
    let begin = hashes + 1;
    let end = format!("\"{}", "#".repeat(hashes));
    let found = text[begin..].find(&end);
    found.map_or(text.len(), |at| begin + at + end.len())
}

fn quoted(text: &str, end: char) -> usize {
    let mut escaped = false;
    for (at, one) in text.char_indices().skip(1) {
        if escaped {
            escaped = false;
        } else if one == end {
            return at + 1;
        } else {
            escaped = one == '\\';
        }
    }
    text.len()
}

/// And no lifetime.
fn is_character(text: &str) -> bool {
    let mut all = text.chars();
    match (all.next(), all.next(), all.next()) {
        (Some('\''), Some('\\'), _) => true,
        (Some('\''), Some(_), third) => third == Some('\''),
        _ => false,
    }
}

/// With comments in it.
fn comment(text: &str) -> usize {
    let (mut depth, mut rest) = (0, text);
    while !rest.is_empty() {
        if let Some(behind) = rest.strip_prefix("/*") {
            depth += 1;
            rest = behind;
        } else if let Some(behind) = rest.strip_prefix("*/") {
            depth -= 1;
            rest = behind;
            if depth == 0 {
                break;
            }
        } else {
            let mut all = rest.chars();
            all.next();
            rest = all.as_str();
        }
    }
    text.len() - rest.len()
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    const TEXT: &str = r##"use std::time::Duration; // u128
/* i128 /* u128 */ u128 */
fn a<'a>(text: &'a str) -> usize { text.len() + "u128 \" u128".len() + b"i128".len() }
const B: ([char; 3], u8) = (['"', '\'', '\u{128}'], b'"');
const C: &str = r#"of "u128""#;
fn d(time: Duration) -> u64 { time.as_nanos() as u64 + time.as_millis() as u64 }
fn e(as_u128: u64) -> u128 { u128::from(as_u128) }
#[cfg(test)]
#[expect(missing_docs, reason = "u128; of a test")]
mod tests { fn f(_: [u128; 2]) { let _ = [0; 2]; } }
fn g() -> u64 { (7_i128 >> 1) as u64 }
#[cfg(all(test, feature = "h"))]
use std::primitive::{i128, u128};
#[cfg(any(test, feature = "h"))]
type H = i128;
"##;

    #[test]
    fn only_code_counts_that_is_not_for_tests_alone() {
        let tokens = tokens(TEXT);
        assert_eq!(lines(&without_tests(&tokens)), [7, 11, 15]);
    }

    #[test]
    fn all_modules_are_read_but_those_for_tests() {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, text) in [
            ("lib.rs", "pub mod a;\n#[cfg(test)]\nmod tests;\n"),
            ("tests.rs", "type A = u128;\n"),
            ("a/mod.rs", "mod b;\n"),
            ("a/b.rs", "\ntype A = u128;\n"),
        ] {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
            fs::write(path, text).expect("written");
        }
        let entry = folder.path().join("lib.rs");
        let uses = uses_below(folder.path(), &entry, folder.path());
        assert_eq!(uses.expect("a crate"), [("a/b.rs".to_owned(), 2)]);
    }

    #[test]
    fn exceptions_are_left_out_and_those_that_are_none_any_more_are_named() {
        let needed = NEEDED.map(|(path, _)| (path.to_owned(), 7));
        assert_eq!(judged(&needed), [""; 0]);
        let findings = judged(&[("skills/src/lib.rs".to_owned(), 3)]);
        assert_eq!(findings.len(), 1 + NEEDED.len());
        assert!(findings[0].starts_with("skills/src/lib.rs:3: "));
    }
}
