//! Values and places for the tests.

use std::fs;
use std::path::Path;

use coordination::symbols::{Namespace, SymbolTable, TableBuilder};
use tempfile::TempDir;

/// A small value whose parts must agree.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Encoders {
    pub left_rad: f64,
    pub right_rad: f64,
}
coordination::datatype!(Encoders, "encoders");

/// As large as a scan gets.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Scan {
    pub ranges_mm: [u32; 1024],
}
coordination::datatype!(Scan, "range_scan");

/// The same name as [`Encoders`], and another size.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct OtherEncoders {
    pub left_rad: f64,
}
coordination::datatype!(OtherEncoders, "encoders");

/// A place of its own for one test.
pub struct Room {
    pub place: Namespace,
    folder: TempDir,
}

impl Room {
    pub fn new() -> Self {
        // In memory, as a robot's folder in /run is.
        let folder = tempfile::tempdir_in("/dev/shm").expect("a temporary folder");
        let place = Namespace::new(folder.path().join("run"), "test_");
        Self { place, folder }
    }

    pub fn root(&self) -> &Path {
        &self.place.root
    }

    /// The names in the root folder.
    pub fn files(&self) -> Vec<String> {
        let Ok(entries) = fs::read_dir(&self.place.root) else {
            return Vec::new();
        };
        let name = |entry: std::io::Result<fs::DirEntry>| {
            entry
                .expect("a readable folder")
                .file_name()
                .into_string()
                .expect("plain names")
        };
        let mut names: Vec<_> = entries.map(name).collect();
        names.sort();
        names
    }

    /// The words of the runs whose folders exist now.
    pub fn words(&self) -> Vec<String> {
        let files = self.files();
        let words = files.iter().filter_map(|name| name.split_once('.'));
        words
            .map(|(_, word)| word.to_owned())
            .filter(|word| word != "pid")
            .collect()
    }

    /// Asserts that neither the folder nor the shared memory of these runs holds anything.
    pub fn assert_nothing_left(&self, words: &[String]) {
        assert_eq!(self.files(), [""; 0], "in {}", self.folder.path().display());
        assert_eq!(shared_memory(words), [""; 0]);
    }
}

/// The shared memory of these runs.
pub fn shared_memory(words: &[String]) -> Vec<String> {
    let entries = fs::read_dir("/dev/shm").expect("Linux has /dev/shm");
    entries
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|name| words.iter().any(|word| name.contains(word.as_str())))
        .collect()
}

/// A table with one small and one large symbol.
pub fn small_table(robot: &str, place: &Namespace) -> SymbolTable {
    let mut builder = TableBuilder::new(robot, place);
    builder.declare::<Encoders>("drive", "drive").unwrap();
    builder.declare::<Scan>("lidar", "front").unwrap();
    builder.build().unwrap()
}
