use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};

use super::*;
use contract::level::PROTOCOL_ID;
use coordination::protocol::Level;
use redb::ReadableTable as _;

fn entries() -> Vec<Entry> {
    let level = Level {
        protocol: PROTOCOL_ID,
        run: 3,
        path: 1,
        progress: 2,
        after_abort: true,
    };
    vec![
        Entry::Epoch(2),
        Entry::Robot {
            robot: "amr-1".into(),
            record: RobotRecord {
                session: 4,
                boot_epoch: u64::MAX,
                issued: 5,
                retired: vec![1, 2],
                found: vec![3],
                seconds: vec![SecondRecord {
                    boot_epoch: 3,
                    sequence: 9,
                    alone: true,
                    stands_in: vec!["2".into()],
                    with_robot: vec!["1".into()],
                    before: Some(Before::Outside),
                }],
                stands_in: vec!["1".into(), "2".into()],
                fsm_state: "drive-1".into(),
                unaccounted: true,
                absent: true,
            },
        },
        Entry::Access {
            robot: "amr-1".into(),
            area: "1".into(),
            record: AccessRecord {
                level,
                fence: 9,
                ticket: 7,
                passed: 3,
            },
        },
        Entry::Fence {
            area: "1".into(),
            fence: 9,
        },
        Entry::Revocation {
            robot: "amr-1".into(),
            area: "1".into(),
            record: RevocationRecord { level, fence: 9 },
        },
        Entry::Number(12),
        coordination(11),
        coordination(12),
        Entry::Coordination {
            number: 11,
            record: None,
        },
    ]
}

fn coordination(number: u64) -> Entry {
    let level = Level {
        protocol: PROTOCOL_ID,
        run: 0,
        path: 1,
        progress: 2,
        after_abort: false,
    };
    let record = CoordinationRecord {
        coordination: "overtaking".into(),
        situation: Some("normal-ahead".into()),
        marking: vec!["normal-in-1".into()],
        waiting: [("normal-done1".into(), 2)].into(),
        parts: vec![PartRecord {
            role: "normal".into(),
            robot: "amr-1".into(),
            level: level.into(),
            own: Some(level.into()),
            kept: vec![("5".into(), true)],
        }],
    };
    Entry::Coordination {
        number,
        record: Some(record),
    }
}

#[test]
fn what_was_written_is_there_after_opening_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("journal.redb");
    let (store, stored) = Store::open(&path, "corridor").expect("opens");
    let nothing = Stored::new(stored.journal);
    assert_eq!(stored, nothing);
    store.write(&entries()).expect("writes");
    store.write(&[Entry::Epoch(3)]).expect("writes");
    drop(store);
    let (_, stored) = Store::open(&path, "corridor").expect("opens again");
    let mut expected = nothing;
    entries()
        .into_iter()
        .for_each(|entry| expected.apply(entry));
    expected.apply(Entry::Epoch(3));
    assert_eq!(stored, expected);
}

#[test]
fn the_journal_of_another_site_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("journal.redb");
    drop(Store::open(&path, "corridor").expect("opens"));
    let error = Store::open(&path, "docking").expect_err("refused");
    let text = error.to_string();
    assert!(
        text.contains("corridor") && text.contains("docking"),
        "{text}"
    );
}

#[test]
fn the_file_is_nobody_elses_and_no_link_is_followed() {
    let folder = tempfile::tempdir().expect("a folder");
    let [path, link, other] = ["first", "link", "other"].map(|name| folder.path().join(name));
    let mode = |path: &Path| std::fs::metadata(path).expect("there").mode() & 0o7777;
    let open = |path: &Path| {
        let permissions = std::fs::Permissions::from_mode(0o644);
        std::fs::set_permissions(path, permissions).expect("it is ours");
    };
    drop(Store::open(&path, "corridor").expect("opens"));
    assert_eq!(mode(&path), 0o600);
    // As earlier versions left it.
    open(&path);
    drop(Store::open(&path, "corridor").expect("opens"));
    assert_eq!(mode(&path), 0o600);
    // What is no journal stays as it is.
    std::fs::write(&other, "no journal").expect("written");
    open(&other);
    assert!(Store::open(&other, "corridor").is_err());
    assert_eq!(mode(&other), 0o644);
    std::os::unix::fs::symlink(&path, &link).expect("a link");
    let error = Store::open(&link, "corridor").expect_err("refused");
    assert!(error.to_string().contains("is a symbolic link"), "{error}");
}

#[test]
fn two_mediators_cannot_have_one_journal() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("journal.redb");
    let _open = Store::open(&path, "corridor").expect("opens");
    let error = Store::open(&path, "corridor").expect_err("refused");
    assert!(error.to_string().contains("another mediator"), "{error}");
}

#[test]
fn a_copy_is_another_journal() {
    let folder = tempfile::tempdir().expect("a folder");
    let [path, copy, moved] = ["first", "copy", "moved"].map(|name| folder.path().join(name));
    let journal = |path: &std::path::Path| {
        let (_, stored) = Store::open(path, "corridor").expect("opens");
        assert_ne!(stored.journal, 0);
        stored.journal
    };
    let first = journal(&path);
    assert_eq!(journal(&path), first);
    std::fs::copy(&path, &copy).expect("a copy");
    assert_ne!(journal(&copy), first);
    std::fs::rename(&path, &moved).expect("moved");
    assert_eq!(journal(&moved), first);
}

/// Changes what the journal says of its file.
fn change_file(path: &Path, change: impl FnOnce(&mut serde_json::Map<String, serde_json::Value>)) {
    const TABLE: redb::TableDefinition<&str, &str> = redb::TableDefinition::new("journal");
    let database = redb::Database::open(path).expect("a journal");
    let writing = database.begin_write().expect("writes");
    {
        let mut table = writing.open_table(TABLE).expect("a table");
        let row = table.get("file").expect("reads").expect("a row");
        let mut file = serde_json::from_str(row.value()).expect("JSON");
        drop(row);
        change(&mut file);
        let row = serde_json::to_string(&file).expect("JSON");
        table.insert("file", row.as_str()).expect("writes");
    }
    writing.commit().expect("writes");
}

/// A file system may have another device number after a reboot.
#[test]
fn a_journal_is_known_by_its_file_and_not_by_the_device() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("journal.redb");
    let journal = || {
        let (_, stored) = Store::open(&path, "corridor").expect("opens");
        stored.journal
    };
    let first = journal();
    if std::fs::metadata(&path).expect("there").created().is_ok() {
        change_file(&path, |file| {
            file.insert("device".into(), 12_345.into());
        });
        assert_eq!(journal(), first);
        // As earlier versions wrote it.
        change_file(&path, |file| {
            assert!(file.remove("born_ns").is_some());
        });
        assert_eq!(journal(), first);
        // Another file that was given the same inode.
        change_file(&path, |file| {
            assert!(file.insert("born_ns".into(), 1.into()).is_some());
        });
        assert_ne!(journal(), first);
    }
    let second = journal();
    change_file(&path, |file| {
        file.remove("born_ns");
        file.insert("device".into(), 12_345.into());
    });
    assert_ne!(journal(), second);
}

#[test]
fn a_file_that_is_no_journal_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("journal.redb");
    std::fs::write(&path, "not a journal").expect("writes");
    assert!(Store::open(&path, "corridor").is_err());
}

#[test]
fn a_file_that_was_cut_off_is_refused_in_words() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("journal.redb");
    let (store, _) = Store::open(&path, "corridor").expect("opens");
    store.write(&entries()).expect("writes");
    drop(store);
    let whole = std::fs::read(&path).expect("it is there");
    // Amid its head, after its first page, amid its tables, and all but the last byte.
    for length in [
        1,
        100,
        4096,
        whole.len() / 3,
        whole.len() / 2,
        whole.len() - 1,
    ] {
        std::fs::write(&path, &whole[..length]).expect("written");
        let error = Store::open(&path, "corridor").expect_err("refused");
        let text = error.to_string();
        assert!(
            matches!(error, StoreError::Store { .. }) && text.contains("if the file is damaged"),
            "{length}: {text}"
        );
    }
    std::fs::write(&path, &whole).expect("written");
    Store::open(&path, "corridor").expect("opens again");
}

/// A disk that can be full.
#[derive(Clone, Debug, Default)]
struct Disk {
    bytes: Arc<Mutex<Vec<u8>>>,
    full: Arc<AtomicBool>,
}

impl Disk {
    fn room(&self) -> std::io::Result<MutexGuard<'_, Vec<u8>>> {
        if self.full.load(Ordering::Relaxed) {
            return Err(std::io::ErrorKind::StorageFull.into());
        }
        Ok(self.bytes.lock().expect("nobody panics"))
    }
}

impl redb::StorageBackend for Disk {
    fn len(&self) -> std::io::Result<u64> {
        Ok(self.bytes.lock().expect("nobody panics").len() as u64)
    }

    fn read(&self, offset: u64, out: &mut [u8]) -> std::io::Result<()> {
        let start = usize::try_from(offset).expect("small");
        let bytes = self.bytes.lock().expect("nobody panics");
        out.copy_from_slice(&bytes[start..start + out.len()]);
        Ok(())
    }

    fn set_len(&self, length: u64) -> std::io::Result<()> {
        self.room()?
            .resize(usize::try_from(length).expect("small"), 0);
        Ok(())
    }

    fn sync_data(&self) -> std::io::Result<()> {
        Ok(())
    }

    fn write(&self, offset: u64, data: &[u8]) -> std::io::Result<()> {
        let start = usize::try_from(offset).expect("small");
        self.room()?[start..start + data.len()].copy_from_slice(data);
        Ok(())
    }
}

#[test]
fn what_a_full_disk_did_not_take_is_written_when_it_has_room() {
    let disk = Disk::default();
    let (mut store, _) = Store::on(disk.clone(), "corridor", 7).expect("opens");
    store.write(&[Entry::Epoch(3)]).expect("writes");
    disk.full.store(true, Ordering::Relaxed);
    for _ in 0..3 {
        let error = store.write(&entries()).expect_err("it is full");
        assert!(matches!(error, StoreError::Disk { .. }), "{error}");
        assert!(error.to_string().contains("free space"), "{error}");
        // With nothing to write it may open.
        let _ = store.reopen();
    }
    disk.full.store(false, Ordering::Relaxed);
    store.reopen().expect("opens again");
    store.write(&entries()).expect("writes");
    drop(store);
    let (_, stored) = Store::on(disk, "corridor", 7).expect("opens");
    let mut expected = Stored::new(stored.journal);
    expected.apply(Entry::Epoch(3));
    { entries().into_iter() }.for_each(|entry| expected.apply(entry));
    assert_eq!(stored, expected);
}

#[test]
fn another_file_in_its_place_is_not_written_to() {
    let folder = tempfile::tempdir().expect("a folder");
    let [path, other] = ["journal.redb", "other.redb"].map(|name| folder.path().join(name));
    let (mut store, _) = Store::open(&path, "corridor").expect("opens");
    store.reopen().expect("it is the same");
    drop(Store::open(&other, "corridor").expect("opens"));
    std::fs::rename(&other, &path).expect("moved");
    let error = store.reopen().expect_err("refused");
    assert!(matches!(error, StoreError::Replaced { .. }), "{error}");
}
