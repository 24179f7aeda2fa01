//! `cargo xtask house`: what the workspace's own sources break of its rules. `cargo xtask pages`: the commands of all pages.

use std::path::Path;
use std::process::ExitCode;

use xtask::ReadError;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let result = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["house"] => house(&root),
        ["pages"] => pages(&root),
        _ => {
            eprintln!("usage: cargo xtask house | pages");
            return ExitCode::from(2);
        }
    };
    result.unwrap_or_else(|error| {
        eprintln!("{error}");
        ExitCode::from(2)
    })
}

fn house(root: &Path) -> Result<ExitCode, ReadError> {
    let findings = xtask::findings(root)?;
    for finding in &findings {
        println!("{finding}");
    }
    Ok(if findings.is_empty() {
        println!("no circle of modules, no arrow upward, no long file without a reason");
        ExitCode::SUCCESS
    } else {
        println!("{} findings", findings.len());
        ExitCode::FAILURE
    })
}

fn pages(root: &Path) -> Result<ExitCode, ReadError> {
    for command in xtask::pages::commands(root)? {
        println!(
            "{}:{}: {}",
            command.page.display(),
            command.line,
            command.text
        );
    }
    Ok(ExitCode::SUCCESS)
}
