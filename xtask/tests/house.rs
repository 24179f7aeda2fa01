//! The rules that the workspace's own sources keep.

use std::path::Path;

#[test]
fn the_house_stands() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let findings = xtask::findings(&root).expect("readable sources");
    assert!(findings.is_empty(), "{}", findings.join("\n"));
}
