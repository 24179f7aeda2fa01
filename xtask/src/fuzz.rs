//! Fuzzing with the stable compiler: libFuzzer needs the coverage that LLVM counts, not a nightly toolchain.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};

use thiserror::Error;

/// What `cargo fuzz` sets, without the address sanitizer: what is fuzzed has no unsafe code.
const RUSTFLAGS: &str = "--cfg fuzzing -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
     -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
     -Cllvm-args=-sanitizer-coverage-trace-compares -Cllvm-args=-simplifycfg-branch-fold-threshold=0 \
     -Ccodegen-units=1";
const LIMITS: [&str; 3] = ["-timeout=10", "-rss_limit_mb=1024", "-print_final_stats=1"];

/// Fuzzing did not begin.
#[derive(Debug, Error)]
#[error("{what}: {why}")]
pub struct FuzzError {
    what: String,
    why: String,
}

/// A program of `config/fuzz`, with the folders of inputs it begins with and what it alone is told.
struct Target {
    name: &'static str,
    seeds: &'static [&'static str],
    options: &'static [&'static str],
}

const TARGETS: [Target; 2] = [
    Target {
        name: "net_file",
        seeds: &["config/nets"],
        options: &["-dict=config/fuzz/net.dict", "-max_len=16384"],
    },
    Target {
        name: "net_model",
        seeds: &[],
        options: &[],
    },
];

/// How one target ended.
pub struct Fuzzed {
    /// Its name.
    pub target: &'static str,
    /// All that it said.
    pub log: PathBuf,
    /// 0 when it found nothing.
    pub status: ExitStatus,
}

/// Builds all targets, and runs them side by side for this time. Inputs that led somewhere new are kept in
/// `target/fuzz/corpus`, those that fail in `target/fuzz/artifacts`.
///
/// # Errors
/// [`FuzzError`] when a program cannot be built or started, or a folder not made.
pub fn run(root: &Path, seconds: u32) -> Result<Vec<Fuzzed>, FuzzError> {
    let host = host()?;
    let output = root.join("target/fuzz");
    // With a target named, build scripts and procedural macros are left without the flags.
    let built = Command::new("cargo")
        .args(["build", "--release", "--locked", "--target", &host])
        .arg("--target-dir")
        .arg(&output)
        .env("RUSTFLAGS", RUSTFLAGS)
        .current_dir(root.join("config/fuzz"))
        .status();
    if !built.map_err(|error| failed("cargo", error))?.success() {
        return Err(failed("the fuzz targets", "they do not compile"));
    }
    let programs = output.join(host).join("release");
    let running = TARGETS
        .iter()
        .map(|target| start(root, target, &programs, &output, seconds))
        .collect::<Result<Vec<_>, _>>()?;
    let ended = running.into_iter().map(|(target, log, mut child)| {
        let status = child.wait().map_err(|error| failed(target.name, error))?;
        Ok(Fuzzed {
            target: target.name,
            log,
            status,
        })
    });
    ended.collect()
}

fn start<'a>(
    root: &Path,
    target: &'a Target,
    programs: &Path,
    output: &Path,
    seconds: u32,
) -> Result<(&'a Target, PathBuf, Child), FuzzError> {
    let name = target.name;
    let corpus = format!("target/fuzz/corpus/{name}");
    let artifacts = format!("target/fuzz/artifacts/{name}/");
    for folder in [&corpus, &artifacts] {
        std::fs::create_dir_all(root.join(folder)).map_err(|error| failed(folder, error))?;
    }
    let path = output.join(format!("{name}.log"));
    let log = File::create(&path).map_err(|error| failed(name, error))?;
    let child = Command::new(programs.join(name))
        .arg(corpus)
        .args(target.seeds)
        .args(target.options)
        .args(LIMITS)
        .arg(format!("-max_total_time={seconds}"))
        .arg(format!("-artifact_prefix={artifacts}"))
        .current_dir(root)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(log)
        .spawn()
        .map_err(|error| failed(name, error))?;
    Ok((target, path, child))
}

/// The machine's own target, as the compiler calls it.
fn host() -> Result<String, FuzzError> {
    let output = Command::new("rustc").arg("-vV").output();
    let output = output.map_err(|error| failed("rustc", error))?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let host = text.lines().find_map(|line| line.strip_prefix("host: "));
    host.map(str::to_owned)
        .ok_or_else(|| failed("rustc -vV", "it names no host"))
}

fn failed(what: &str, why: impl ToString) -> FuzzError {
    FuzzError {
        what: what.to_owned(),
        why: why.to_string(),
    }
}
