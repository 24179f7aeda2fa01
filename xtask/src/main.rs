//! `cargo xtask house`: what the workspace's own sources break of its rules. `cargo xtask pages`: the commands of all pages.
//! `cargo xtask fuzz [SECONDS]`: the fuzz targets, a minute each unless told otherwise.

use std::path::Path;
use std::process::ExitCode;

use xtask::ReadError;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    if let [command, rest @ ..] = &arguments[..]
        && command == "fuzz"
    {
        return fuzz(&root, rest);
    }
    let result = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["house"] => house(&root),
        ["pages"] => pages(&root),
        _ => {
            eprintln!("usage: cargo xtask house | pages | fuzz [SECONDS]");
            return ExitCode::from(2);
        }
    };
    result.unwrap_or_else(|error| {
        eprintln!("{error}");
        ExitCode::from(2)
    })
}

fn fuzz(root: &Path, arguments: &[String]) -> ExitCode {
    const SECONDS: u32 = 60;
    const TAIL: usize = 12;
    let seconds = match arguments {
        [] => Some(SECONDS),
        [seconds] => seconds.parse().ok().filter(|&seconds| seconds > 0),
        _ => None,
    };
    let Some(seconds) = seconds else {
        eprintln!("usage: cargo xtask fuzz [SECONDS], a whole number from 1");
        return ExitCode::from(2);
    };
    let targets = match xtask::fuzz::run(root, seconds) {
        Ok(targets) => targets,
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::from(2);
        }
    };
    let mut code = ExitCode::SUCCESS;
    for target in targets {
        let log = std::fs::read(&target.log).unwrap_or_default();
        let text = String::from_utf8_lossy(&log);
        let lines: Vec<&str> = text.lines().collect();
        let tail = &lines[lines.len().saturating_sub(TAIL)..];
        println!("{}: {}", target.target, target.status);
        println!("{}", tail.join("\n"));
        if !target.status.success() {
            println!("the whole of it: {}", target.log.display());
            code = ExitCode::FAILURE;
        }
    }
    code
}

fn house(root: &Path) -> Result<ExitCode, ReadError> {
    let findings = xtask::findings(root)?;
    for finding in &findings {
        println!("{finding}");
    }
    Ok(if findings.is_empty() {
        println!("no circle, no arrow upward, no long file without a reason, no 128 bits");
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
