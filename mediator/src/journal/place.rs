//! By what the file of a journal is known again, and told from a copy of it.

use std::fs::Metadata;
use std::os::unix::fs::MetadataExt;
use std::time::UNIX_EPOCH;

/// By what a file is known again.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Place {
    /// Of a file system without a device of its own (btrfs, overlay, NFS) this may be another number after each mount.
    pub(super) device: u64,
    pub(super) inode: u64,
    /// When it was made, by the clock of its computer; none where the file system does not keep that.
    pub(super) born_ns: Option<u64>,
}

impl Place {
    pub(super) fn of(metadata: &Metadata) -> Self {
        let born = { metadata.created().ok() }.and_then(|at| at.duration_since(UNIX_EPOCH).ok());
        Self {
            device: metadata.dev(),
            inode: metadata.ino(),
            // 0 is what some say that do not keep it.
            born_ns: { born.and_then(|own| u64::try_from(own.as_nanos()).ok()) }
                .filter(|&own| own > 0),
        }
    }

    /// Whether both are of one file. A copy is made later than the file, and has another inode on the same file system.
    pub(super) fn is(self, other: Self) -> bool {
        let born_alike = match (self.born_ns, other.born_ns) {
            (Some(own), Some(others)) => own == others,
            _ => self.device == other.device,
        };
        self.inode == other.inode && born_alike
    }
}
