//! Symbols that come and go while a robot runs (the paper's Sections 3.3 and 4): an arm is mounted, which
//! registers what it measures; a watcher finds it by its semantic id, reads it, and is told when the arm is
//! gone. The symbols that were there before are written and read all the time.
//!
//! ```sh
//! cargo run -p coordination --features symbols --example registration
//! ```

use std::error::Error;
use std::process::ExitCode;

use coordination::symbols::{Inspector, Namespace, SemanticId, TableBuilder};

/// Both driven wheels.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Encoders {
    left_rad: f64,
    right_rad: f64,
}
coordination::datatype!(Encoders, "encoders");

/// One joint, as the maker of the arm describes it.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Joint {
    angle_rad: f64,
    torque_nm: f64,
}
coordination::datatype!(Joint, "joint", "urn:example:arms:2");

/// The same name by another metamodel: not what a watcher of arms expects.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct OldJoint {
    angle_deg: f64,
    current_a: f64,
}
coordination::datatype!(OldJoint, "joint", "urn:example:arms:1");

fn main() -> ExitCode {
    match run() {
        Ok(lines) => {
            lines.iter().for_each(|line| println!("{line}"));
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// What it says, line by line.
///
/// # Errors
/// If shared memory cannot be had, or a symbol is not found.
pub fn run() -> Result<Vec<String>, Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let place = Namespace::new(folder.path().join("run"), "example_");
    let mut lines = Vec::new();

    // What the robot always has is declared, and fixed when its threads start.
    let mut builder = TableBuilder::new("amr", &place);
    builder.declare::<Encoders>("drive", "drive")?;
    let table = builder.build()?;
    let mut drive = table.writer::<Encoders>("drive", "drive")?;
    let mut odometry = table.reader::<Encoders>("odometry", "drive")?;
    table.seal()?;

    // Later an arm is mounted. Whoever wants to know, in this process or another, looks into the directory.
    let mut elbow = table.add::<Joint>("arm", "elbow")?;
    let inspector = Inspector::open("amr", &place)?;
    let wanted = SemanticId::of::<Joint>("elbow");
    let found = inspector
        .directory()
        .into_iter()
        .find(|info| info.semantic_id() == wanted);
    let found = found.ok_or("the elbow is not listed")?;
    lines.push(format!(
        "found {}, of `{}`",
        found.semantic_id(),
        found.owner
    ));
    let mut watch = inspector.reader::<Joint>("elbow")?;

    for step in 1..=3_u32 {
        let angle_rad = f64::from(step) / 10.0;
        drive.write(
            step.into(),
            &Encoders {
                left_rad: angle_rad,
                right_rad: angle_rad,
            },
        );
        elbow.write(
            step.into(),
            &Joint {
                angle_rad,
                torque_nm: 1.5,
            },
        );
        let (joint, wheels) = (watch.read().value, odometry.read().value);
        lines.push(format!(
            "elbow {:.1} rad at {:.1} Nm, wheels {:.1} rad",
            joint.angle_rad, joint.torque_nm, wheels.left_rad
        ));
    }

    // Name and size are the same, the meaning is not.
    match inspector.reader::<OldJoint>("elbow") {
        Err(error) => lines.push(format!("refused: {error}")),
        Ok(_) => return Err("a reader of another metamodel got in".into()),
    }

    drop(elbow);
    table.remove::<Joint>("arm", "elbow")?;
    lines.push(format!("the arm is gone: {}", watch.is_removed()));
    drive.write(
        4,
        &Encoders {
            left_rad: 0.4,
            right_rad: 0.4,
        },
    );
    lines.push(format!(
        "and the wheels go on: {:.1} rad",
        odometry.read().value.left_rad
    ));
    Ok(lines)
}
