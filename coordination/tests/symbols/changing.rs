//! Symbols that are acquired and released, added and removed while others are used.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::Duration;

use bytemuck::Zeroable;
use coordination::symbols::{
    Datatype, Inspector, METAMODEL, SemanticId, SymbolError, SymbolTable, Writer,
};

use crate::common::{Encoders, OtherEncoders, Room, Scan, shared_memory, small_table};

fn both(rad: f64) -> Encoders {
    Encoders {
        left_rad: rad,
        right_rad: rad,
    }
}

/// A sealed table with both of its writers.
fn sealed(room: &Room) -> (SymbolTable, Writer<Encoders>, Writer<Scan>) {
    let table = small_table("a", &room.place);
    let drive = table.writer::<Encoders>("drive", "drive").unwrap();
    let lidar = table.writer::<Scan>("lidar", "front").unwrap();
    table.seal().unwrap();
    (table, drive, lidar)
}

fn readers(table: &SymbolTable, model: &str) -> Vec<String> {
    let directory = table.directory();
    let info = directory.into_iter().find(|info| info.model == model);
    info.expect("it is listed").readers
}

#[test]
fn what_is_dropped_can_be_acquired_again() {
    let room = Room::new();
    let table = small_table("a", &room.place);
    for round in 1..=3 {
        let mut writer = table.writer::<Encoders>("drive", "drive").unwrap();
        let mut reader = table.reader::<Encoders>("x", "drive").unwrap();
        assert!(!reader.read().is_written(), "a new writer begins anew");
        writer.write(round, &both(1.0));
        assert_eq!(reader.read().stamp_ns, round);
        assert!(table.writer::<Encoders>("drive", "drive").is_err());
    }
    let first = table.reader::<Encoders>("x", "drive").unwrap();
    let second = table.reader::<Encoders>("x", "drive").unwrap();
    let other = table.reader::<Encoders>("y", "drive").unwrap();
    assert_eq!(readers(&table, "drive"), ["x", "y"]);
    drop(first);
    assert_eq!(readers(&table, "drive"), ["x", "y"], "x has another");
    drop(second);
    let inspector = Inspector::open("a", &room.place).unwrap();
    assert_eq!(inspector.directory()[0].readers, ["y"]);
    drop(other);
    assert_eq!(readers(&table, "drive"), [""; 0]);
    let error = table.seal().unwrap_err();
    assert!(
        error.to_string().contains("encoders/drive of `drive`"),
        "{error}"
    );
}

#[test]
fn a_sealed_table_can_be_extended_and_shortened() {
    let room = Room::new();
    let (table, _drive, _lidar) = sealed(&room);
    let inspector = Inspector::open("a", &room.place).unwrap();
    let mut writer = table.add::<Encoders>("arm", "elbow").unwrap();
    let mut reader = table.reader::<Encoders>("watch", "elbow").unwrap();
    let mut outside = inspector.reader::<Encoders>("elbow").unwrap();
    writer.write(5, &both(2.5));
    assert_eq!(reader.read().value, both(2.5));
    assert_eq!(outside.read().value, both(2.5));
    let listed = inspector.directory();
    assert_eq!((listed.len(), &listed), (3, &table.directory()));
    let elbow = &listed[2];
    assert_eq!(
        (&*elbow.owner, elbow.is_added, &elbow.readers[..]),
        ("arm", true, &["watch".to_owned()][..])
    );
    assert!(!listed[0].is_added);

    let message = |error: SymbolError| error.to_string();
    assert!(
        message(table.add::<Encoders>("x", "drive").err().unwrap())
            .contains("declared by `drive` and again by `x`")
    );
    assert!(
        message(table.remove::<Encoders>("x", "elbow").unwrap_err()).contains("which `arm` owns")
    );
    assert_eq!(
        message(table.remove::<Encoders>("drive", "drive").unwrap_err()),
        "encoders/drive was declared before the table was built and stays; only added symbols can be removed"
    );
    drop(writer);
    let mut writer = table.writer::<Encoders>("arm", "elbow").unwrap();
    assert!(matches!(
        table.reader::<Encoders>("late", "drive"),
        Err(SymbolError::Sealed { .. })
    ));

    assert!(!reader.is_removed() && !outside.is_removed());
    table.remove::<Encoders>("arm", "elbow").unwrap();
    assert!(reader.is_removed() && outside.is_removed());
    assert_eq!(
        (table.directory().len(), inspector.directory().len()),
        (2, 2)
    );
    assert!(matches!(
        table.reader::<Encoders>("watch", "elbow"),
        Err(SymbolError::Unknown { .. })
    ));
    assert!(matches!(
        inspector.reader::<Encoders>("elbow"),
        Err(SymbolError::Unknown { .. })
    ));
    writer.write(6, &both(3.0));
    assert_eq!(reader.read().stamp_ns, 6, "handles go on");

    // The name is free at once, also for another layout, and old handles do not disturb the new ones.
    let mut other = table.add::<OtherEncoders>("arm", "elbow").unwrap();
    let mut new_reader = table.reader::<OtherEncoders>("watch", "elbow").unwrap();
    other.write(7, &OtherEncoders { left_rad: 9.0 });
    drop((reader, writer));
    assert_eq!(new_reader.read().stamp_ns, 7);
    assert_eq!(readers(&table, "elbow"), ["watch"]);
    assert!(
        table.writer::<OtherEncoders>("arm", "elbow").is_err(),
        "still taken"
    );
}

#[test]
fn pages_are_freed_with_the_last_handle() {
    let room = Room::new();
    let (table, drive, lidar) = sealed(&room);
    let words = room.words();
    let before = shared_memory(&words).len();
    let writer = table.add::<Scan>("arm", "camera").unwrap();
    let reader = table.reader::<Scan>("x", "camera").unwrap();
    assert!(shared_memory(&words).len() > before);
    table.remove::<Scan>("arm", "camera").unwrap();
    drop(writer);
    assert!(shared_memory(&words).len() > before, "it is read");
    drop(reader);
    assert_eq!(shared_memory(&words).len(), before);
    // One that is never removed goes with the table, whatever is dropped last.
    let mut last = table.add::<Scan>("arm", "camera").unwrap();
    drop((table, drive, lidar));
    last.write(1, &Scan::zeroed());
    drop(last);
    room.assert_nothing_left(&words);
}

#[test]
fn bounds_are_told() {
    let room = Room::new();
    let (table, ..) = sealed(&room);
    let mut writers = Vec::new();
    let error = (0..200).find_map(|number| {
        let added = table.add::<Encoders>("arm", &format!("m{number}"));
        added.map(|writer| writers.push(writer)).err()
    });
    assert_eq!(
        error.unwrap().to_string(),
        "there are more than 128 symbols"
    );
    assert_eq!(writers.len(), 126);
    table.remove::<Encoders>("arm", "m7").unwrap();
    assert!(table.add::<Encoders>("arm", "again").is_ok());
    // Activities that no symbol names any more make room for others.
    table.remove::<Encoders>("arm", "m8").unwrap();
    for number in 0..100 {
        let owner = format!("owner{number}");
        drop(table.add::<Encoders>(&owner, "passing").unwrap());
        table.remove::<Encoders>(&owner, "passing").unwrap();
    }
    assert!(table.add::<Encoders>("a b", "x").is_err());
    assert_eq!(table.directory().len(), 127);
}

/// Every so often who reads and writes leaves the processor to others for a moment.
const BREATH: u64 = 1_000;

#[test]
fn readers_run_on_while_a_thousand_symbols_come_and_go() {
    let room = Room::new();
    let table = small_table("a", &room.place);
    let words = room.words();
    let mut drive = table.writer::<Encoders>("drive", "drive").unwrap();
    let _lidar = table.writer::<Scan>("lidar", "front").unwrap();
    let running: Vec<_> = ["x", "y"]
        .map(|name| table.reader::<Encoders>(name, "drive").unwrap())
        .into();
    table.seal().unwrap();
    let before = shared_memory(&words).len();
    let ended = Arc::new(AtomicBool::new(false));
    let reads = Arc::new(AtomicU64::new(0));
    let mut threads = Vec::new();
    for mut reader in running {
        let (ended, reads) = (Arc::clone(&ended), Arc::clone(&reads));
        threads.push(thread::spawn(move || {
            let mut last = 0;
            while !ended.load(Ordering::Relaxed) {
                let read = reader.read();
                assert_eq!(
                    read.value.left_rad.to_bits(),
                    read.value.right_rad.to_bits()
                );
                assert_eq!(read.value.left_rad, read.stamp_ns as f64);
                assert!(read.stamp_ns >= last && !reader.is_removed());
                last = read.stamp_ns;
                if reads.fetch_add(1, Ordering::Relaxed) % BREATH == 0 {
                    thread::sleep(Duration::from_micros(100));
                }
            }
            assert!(last > 0);
        }));
    }
    let writing = Arc::clone(&ended);
    threads.push(thread::spawn(move || {
        for stamp_ns in 1.. {
            drive.write(stamp_ns, &both(stamp_ns as f64));
            if writing.load(Ordering::Relaxed) {
                break;
            }
            if stamp_ns % BREATH == 0 {
                thread::sleep(Duration::from_micros(100));
            }
        }
    }));
    let follower = crate::processes::follower(&room);
    for round in 1..=1_000 {
        let mut writer = table.add::<Encoders>("arm", "extra").unwrap();
        writer.write(round, &both(round as f64));
        let mut reader = table.reader::<Encoders>("watch", "extra").unwrap();
        assert_eq!(reader.read().value, both(round as f64));
        table.remove::<Encoders>("arm", "extra").unwrap();
        assert!(reader.is_removed());
        assert_eq!(reader.read().stamp_ns, round);
    }
    assert!(reads.load(Ordering::Relaxed) > 1_000);
    ended.store(true, Ordering::Relaxed);
    for thread in threads {
        thread.join().unwrap();
    }
    let mut last = table.add::<Encoders>("arm", "extra").unwrap();
    last.write(1, &both(-1.0));
    follower.end();
    table.remove::<Encoders>("arm", "extra").unwrap();
    drop(last);
    assert_eq!(shared_memory(&words).len(), before);
    drop((table, _lidar));
    room.assert_nothing_left(&words);
}

#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Torque {
    torque_nm: f64,
}
coordination::datatype!(Torque, "torque", "urn:example:arms:2");

#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Nameless {
    value: f64,
}
coordination::datatype!(Nameless, "nameless", "no uri");

/// The name and the size of [`Torque`], and another meaning.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct OldTorque {
    torque_mnm: f64,
}
coordination::datatype!(OldTorque, "torque", "urn:example:arms:1");

#[test]
fn another_metamodel_is_refused() {
    let room = Room::new();
    let (table, ..) = sealed(&room);
    let mut torque = table.add::<Torque>("arm", "elbow").unwrap();
    torque.write(1, &Torque { torque_nm: 2.0 });
    let inspector = Inspector::open("a", &room.place).unwrap();
    let refused = |asked_by: &str| {
        format!(
            "`{asked_by}` reads torque/elbow by the metamodel `urn:example:arms:1`, but `arm` writes it by `urn:example:arms:2`"
        )
    };
    let message = |error: Option<SymbolError>| error.unwrap().to_string();
    assert_eq!(
        message(table.reader::<OldTorque>("watch", "elbow").err()),
        refused("watch")
    );
    assert_eq!(
        message(inspector.reader::<OldTorque>("elbow").err()),
        refused("inspector")
    );
    assert_eq!(
        message(table.writer::<OldTorque>("arm", "elbow").err()),
        refused("arm")
    );
    assert_eq!(
        message(table.remove::<OldTorque>("arm", "elbow").err()),
        refused("arm")
    );
    assert_eq!(readers(&table, "elbow"), [""; 0], "nobody got in");
    let mut reader = inspector.reader::<Torque>("elbow").unwrap();
    assert_eq!(reader.read().value.torque_nm, 2.0);
}

#[test]
fn a_semantic_id_names_its_metamodel() {
    let room = Room::new();
    let (table, ..) = sealed(&room);
    let _torque = table.add::<Torque>("arm", "elbow").unwrap();
    let ids: Vec<_> = table
        .directory()
        .iter()
        .map(|info| info.semantic_id())
        .collect();
    assert_eq!(
        ids,
        [
            SemanticId::of::<Encoders>("drive"),
            SemanticId::of::<Scan>("front"),
            SemanticId::of::<Torque>("elbow"),
        ]
    );
    assert_eq!(Encoders::METAMODEL, METAMODEL);
    assert_eq!(ids[2].to_string(), "urn:example:arms:2#torque/elbow");
    let error = table.add::<Nameless>("arm", "x").err().unwrap();
    assert_eq!(
        error.to_string(),
        "the metamodel `no uri` must be a URI of up to 80 visible ASCII characters"
    );
}
