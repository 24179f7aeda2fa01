//! The commands that pages tell a reader to type.
//!
//! A command is a line of a fenced `sh` block, or inline code that begins like one, in any Markdown page of the repository.

use std::path::{Path, PathBuf};

use crate::files::{ReadError, read};

/// Inline code that begins with one of these is a command.
const BEGINNINGS: [&str; 5] = [
    "cargo ",
    "target/debug/",
    "target/release/",
    "bash ",
    "sudo ",
];
/// Folders whose pages are not ours.
const SKIPPED: [&str; 3] = ["target", ".git", "node_modules"];

/// A command as a page prints it, without its comment.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Command {
    /// The command, with single spaces.
    pub text: String,
    /// The page, from the workspace's root.
    pub page: PathBuf,
    /// The line on it.
    pub line: usize,
}

/// All commands of all pages under `root`.
///
/// # Errors
/// [`ReadError::File`] when a page cannot be read.
pub fn commands(root: &Path) -> Result<Vec<Command>, ReadError> {
    let mut commands = Vec::new();
    for path in pages(root)? {
        let page = path.strip_prefix(root).unwrap_or(&path);
        commands.extend(of_page(page, &read(&path)?));
    }
    commands.sort();
    Ok(commands)
}

/// All Markdown files under `root` that are ours.
fn pages(root: &Path) -> Result<Vec<PathBuf>, ReadError> {
    let mut pages = Vec::new();
    let mut folders = vec![root.to_owned()];
    while let Some(folder) = folders.pop() {
        let entries = std::fs::read_dir(&folder).map_err(|error| ReadError::File {
            path: folder.clone(),
            error,
        })?;
        for path in entries.flatten().map(|entry| entry.path()) {
            let name = path.file_name().and_then(|name| name.to_str());
            if path.is_dir() {
                if !name.is_some_and(|name| SKIPPED.contains(&name)) {
                    folders.push(path);
                }
            } else if path.extension().is_some_and(|extension| extension == "md") {
                pages.push(path);
            }
        }
    }
    pages.sort();
    Ok(pages)
}

/// Every path that a page names and that is not there, as a sentence each.
///
/// A path is inline code with a `/` that ends like a file of ours or with `/`, and the target of a link.
///
/// # Errors
/// [`ReadError::File`] when a page cannot be read.
pub fn broken_paths(root: &Path) -> Result<Vec<String>, ReadError> {
    let mut findings = Vec::new();
    for path in pages(root)? {
        let text = read(&path)?;
        let page = path.strip_prefix(root).unwrap_or(&path);
        let beside = path.parent().unwrap_or(root);
        for (number, line) in text.lines().enumerate() {
            let code = line.split('`').skip(1).step_by(2);
            let links = line.split("](").skip(1);
            let links = links.filter_map(|rest| rest.split([')', '#']).next());
            let named = code.filter(|code| is_path(code)).chain(links);
            let named = named.filter(|named| !named.is_empty() && !named.contains("://"));
            for named in named.filter(|named| !root.join(named).exists()) {
                if !beside.join(named).exists() {
                    let page = page.display();
                    findings.push(format!("{page}:{}: there is no `{named}`", number + 1));
                }
            }
        }
    }
    Ok(findings)
}

fn is_path(code: &str) -> bool {
    let endings = ["/", ".rs", ".toml", ".md", ".proto"];
    let is_made = code.starts_with("target/") || code.starts_with('/');
    code.contains('/')
        && !is_made
        && !code.contains([' ', '<', '*', '{'])
        && endings.iter().any(|ending| code.ends_with(ending))
}

/// The commands of one page.
#[must_use]
pub fn of_page(page: &Path, text: &str) -> Vec<Command> {
    let mut commands: Vec<Command> = Vec::new();
    let mut fence: Option<bool> = None;
    let mut goes_on = false;
    for (number, line) in text.lines().enumerate() {
        let trimmed = line.trim();
        if let Some(language) = trimmed.strip_prefix("```") {
            fence = if fence.is_some() {
                None
            } else {
                Some(language == "sh")
            };
            continue;
        }
        let found: Vec<&str> = match fence {
            Some(true) => vec![trimmed],
            Some(false) => Vec::new(),
            None => inline(line),
        };
        for found in found {
            let written = found.split(" #").next().unwrap_or_default();
            let (written, continues) = match written.trim().strip_suffix('\\') {
                Some(before) => (before, true),
                None => (written, false),
            };
            let words: Vec<&str> = written.split_whitespace().collect();
            let words = words.join(" ");
            if goes_on && let Some(last) = commands.last_mut() {
                last.text += &format!(" {words}");
            } else if !words.is_empty() && !words.starts_with('#') {
                commands.push(Command {
                    text: words,
                    page: page.to_owned(),
                    line: number + 1,
                });
            }
            goes_on = continues;
        }
    }
    commands
}

/// Code between single backticks that begins like a command.
fn inline(line: &str) -> Vec<&str> {
    let code = line.split('`').skip(1).step_by(2);
    code.filter(|code| BEGINNINGS.iter().any(|start| code.starts_with(start)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(page: &str) -> Vec<String> {
        let commands = of_page(Path::new("PAGE.md"), page).into_iter();
        commands.map(|command| command.text).collect()
    }

    #[test]
    fn commands_stand_in_fences_and_in_lines() {
        let page = "Run `cargo xtask house` or `x`:\n```sh\ncargo test   # everything\n\n# only words\ncargo run \\\n  -- a\n```\n";
        assert_eq!(
            texts(page),
            ["cargo xtask house", "cargo test", "cargo run -- a"]
        );
    }

    #[test]
    fn code_in_other_languages_is_no_command() {
        assert_eq!(
            texts("```rust\ncargo test\n```\n```\ncargo x\n```\n"),
            [""; 0]
        );
    }
}
