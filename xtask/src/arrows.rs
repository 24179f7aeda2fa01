//! Which crate may use which: arrows run one way.

use std::path::Path;

use crate::files::{ReadError, read};

/// Each crate with all others of this workspace that it may use. Tests may use more.
const MAY_USE: &[(&str, &[&str])] = &[
    ("coordination", &[]),
    ("description", &["coordination"]),
    ("contract", &["coordination", "description"]),
    ("config", &["coordination", "description"]),
    ("drivers", &["description"]),
    ("skills", &["coordination", "description"]),
    (
        "mediator",
        &["config", "contract", "coordination", "description"],
    ),
    (
        "onboard",
        &[
            "config",
            "contract",
            "coordination",
            "description",
            "drivers",
            "skills",
        ],
    ),
    ("sim", &[]),
    (
        "rig",
        &[
            "config",
            "contract",
            "coordination",
            "description",
            "drivers",
            "mediator",
            "onboard",
            "sim",
            "skills",
        ],
    ),
    ("xtask", &[]),
];

/// The folders of all members of the workspace.
///
/// # Errors
/// [`ReadError`] when the manifest cannot be read.
pub fn members(root: &Path) -> Result<Vec<String>, ReadError> {
    let path = root.join("Cargo.toml");
    let manifest = manifest(&path)?;
    let members = manifest
        .get("workspace")
        .and_then(|workspace| workspace.get("members"))
        .and_then(toml::Value::as_array);
    let members = members.ok_or_else(|| ReadError::Manifest {
        path,
        what: "expected `workspace.members`".to_owned(),
    })?;
    let names = members.iter().filter_map(toml::Value::as_str);
    Ok(names.map(str::to_owned).collect())
}

/// The crates that the member uses and must not.
///
/// # Errors
/// [`ReadError`] when its manifest cannot be read.
pub fn findings(root: &Path, member: &str) -> Result<Vec<String>, ReadError> {
    let path = root.join(member).join("Cargo.toml");
    let manifest = manifest(&path)?;
    let name = manifest
        .get("package")
        .and_then(|package| package.get("name"))
        .and_then(toml::Value::as_str)
        .ok_or_else(|| ReadError::Manifest {
            path,
            what: "expected `package.name`".to_owned(),
        })?;
    let Some((_, may)) = MAY_USE.iter().find(|(own, _)| *own == name) else {
        return Ok(vec![format!(
            "{member}: crate `{name}` has no place in the house; give it one in xtask/src/arrows.rs"
        )]);
    };
    let ours = |used: &&String| MAY_USE.iter().any(|(own, _)| own == used);
    let used = manifest.get("dependencies").and_then(toml::Value::as_table);
    let used = used.into_iter().flat_map(|table| table.keys());
    Ok(used
        .filter(ours)
        .filter(|used| !may.contains(&used.as_str()))
        .map(|used| format!("{member}: `{name}` must not use `{used}`"))
        .collect())
}

fn manifest(path: &Path) -> Result<toml::Table, ReadError> {
    read(path)?.parse().map_err(|error| ReadError::Manifest {
        path: path.to_owned(),
        what: format!("{error}"),
    })
}
