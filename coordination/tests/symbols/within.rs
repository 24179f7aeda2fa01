//! One process: owners, readers, errors, threads.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Barrier};
use std::thread;

use bytemuck::Zeroable;
use coordination::symbols::{Inspector, Namespace, SymbolError, SymbolTable, TableBuilder};

use crate::common::{Encoders, OtherEncoders, Room, Scan, shared_memory, small_table};

fn both(rad: f64) -> Encoders {
    Encoders {
        left_rad: rad,
        right_rad: rad,
    }
}

#[test]
fn a_reader_sees_the_newest_value_with_its_stamp() {
    let room = Room::new();
    let table = small_table("a", &room.place);
    let mut writer = table.writer::<Encoders>("drive", "drive").unwrap();
    let mut reader = table.reader::<Encoders>("control", "drive").unwrap();
    let first = reader.read();
    assert_eq!((first.is_written(), first.age_ns(9)), (false, None));
    for stamp_ns in 1..100 {
        writer.write(stamp_ns, &both(stamp_ns as f64));
        let read = reader.read();
        assert_eq!(
            (read.stamp_ns, read.value),
            (stamp_ns, both(stamp_ns as f64))
        );
    }
    assert_eq!(reader.read().age_ns(100), Some(1));
    assert_eq!(reader.retries(), 0);
}

#[test]
fn the_memory_of_a_program_of_another_width_is_not_read() {
    let room = Room::new();
    let _table = small_table("a", &room.place);
    let instance = room.root().join("a.pid");
    let text = std::fs::read_to_string(&instance).unwrap();
    let (own, other) = (usize::BITS, 96 - usize::BITS);
    let of_other = text.replace(&format!("bits {own}"), &format!("bits {other}"));
    assert_ne!(of_other, text);
    std::fs::write(&instance, of_other).unwrap();
    match Inspector::open("a", &room.place) {
        Err(SymbolError::OtherWidth {
            found, expected, ..
        }) => assert_eq!((found, expected), (other, own)),
        Err(error) => panic!("{error}"),
        Ok(_) => panic!("read with {own} bits what has {other}"),
    }
    std::fs::write(&instance, text).unwrap();
    assert!(Inspector::open("a", &room.place).is_ok());
}

#[test]
fn the_directory_names_owners_readers_and_sizes() {
    let room = Room::new();
    let table = small_table("a", &room.place);
    let _readers = ["control", "navigation", "control"]
        .map(|reader| table.reader::<Encoders>(reader, "drive").unwrap());
    let inspector = Inspector::open("a", &room.place).unwrap();
    assert_eq!(inspector.directory(), table.directory());
    let [encoders, scan] = &inspector.directory()[..] else {
        panic!("two symbols");
    };
    assert_eq!(
        (&*encoders.datatype, &*encoders.model),
        ("encoders", "drive")
    );
    assert_eq!(encoders.owner, "drive");
    assert_eq!(encoders.readers, ["control", "navigation"]);
    assert_eq!(encoders.size_bytes, 16);
    assert_eq!((scan.size_bytes, scan.readers.len()), (4096, 0));
    assert_eq!(inspector.pid(), std::process::id());
    assert!(inspector.is_alive());

    assert!(!inspector.is_sealed());
    let _drive = table.writer::<Encoders>("drive", "drive").unwrap();
    assert_eq!(
        table.seal().unwrap_err().to_string(),
        "declared but not owned, because their writers were never taken: range_scan/front of `lidar`"
    );
    let _lidar = table.writer::<Scan>("lidar", "front").unwrap();
    table.seal().unwrap();
    assert!(inspector.is_sealed());
    assert_eq!(
        table
            .reader::<Scan>("late", "front")
            .unwrap_err()
            .to_string(),
        "`late` asks for range_scan/front after the table was sealed"
    );
}

#[test]
fn a_wrong_request_says_what_there_is() {
    let room = Room::new();
    let table = small_table("a", &room.place);
    let inspector = Inspector::open("a", &room.place).unwrap();
    let message = |error: SymbolError| error.to_string();
    assert_eq!(
        message(table.reader::<Scan>("x", "drive").unwrap_err()),
        "`x` asks for range_scan/drive, but `drive` owns encoders/drive; \
         there are: encoders/drive, range_scan/front"
    );
    assert_eq!(
        message(table.reader::<Encoders>("x", "left").unwrap_err()),
        "`x` asks for encoders/left, which nobody owns; \
         there are: encoders/drive, range_scan/front"
    );
    assert_eq!(
        message(inspector.reader::<OtherEncoders>("drive").unwrap_err()),
        "`inspector` reads encoders/drive as 8 bytes, but `drive` writes 16 bytes"
    );
    assert_eq!(
        message(table.writer::<Scan>("drive", "front").unwrap_err()),
        "`drive` wants to write range_scan/front, which `lidar` owns"
    );
    let _writer = table.writer::<Scan>("lidar", "front").unwrap();
    assert_eq!(
        message(table.writer::<Scan>("lidar", "front").unwrap_err()),
        "`lidar` took the writer of range_scan/front twice"
    );
}

#[test]
fn a_wrong_declaration_is_refused() {
    let room = Room::new();
    let mut builder = TableBuilder::new("a", &room.place);
    builder.declare::<Encoders>("drive", "drive").unwrap();
    assert_eq!(
        builder
            .declare::<OtherEncoders>("control", "drive")
            .unwrap_err()
            .to_string(),
        "symbol encoders/drive is declared by `drive` and again by `control`; it can have one owner"
    );
    builder.declare::<Encoders>("drive", "steer").unwrap();
    let long = "m".repeat(41);
    for model in ["", "a b", "a/b", "ä", long.as_str()] {
        let error = builder.declare::<Encoders>("drive", model).unwrap_err();
        assert!(matches!(error, SymbolError::BadName { .. }), "{model}");
    }
    for activity in 0..31 {
        let name = format!("activity{activity}");
        builder.declare::<Encoders>(&name, &name).unwrap();
    }
    let error = builder.declare::<Encoders>("one_more", "x").unwrap_err();
    assert_eq!(error.to_string(), "there are more than 32 activities");

    let nothing = TableBuilder::new("a", &room.place);
    let error = nothing.build().unwrap_err();
    assert_eq!(error.to_string(), "robot `a` declares no symbol");
    assert!(room.files().is_empty());
}

#[test]
fn a_wrong_place_is_refused() {
    let build = |robot: &str, place: &Namespace| {
        let mut builder = TableBuilder::new(robot, place);
        builder.declare::<Encoders>("drive", "drive").unwrap();
        builder.build().unwrap_err()
    };
    let room = Room::new();
    for robot in ["", "..", "a/b", "a.b", &"r".repeat(33)] {
        let error = build(robot, &room.place);
        assert!(matches!(error, SymbolError::BadName { .. }), "{robot}");
    }
    let prefixed = Namespace::new(room.root(), "../x");
    assert!(matches!(build("a", &prefixed), SymbolError::BadName { .. }));

    let long = Namespace::new(room.root().join("r".repeat(80)), "");
    assert!(matches!(build("a", &long), SymbolError::BadRoot { .. }));

    let file = room.root().join("file");
    std::fs::write(&file, "").unwrap();
    let error = build("a", &Namespace::new(&file, ""));
    assert!(matches!(error, SymbolError::File { .. }), "{error}");
}

#[test]
fn the_longest_names_fit() {
    let room = Room::new();
    let length = room.root().as_os_str().len();
    let root = room.root().join("r".repeat(79 - length));
    let place = Namespace::new(root, "p".repeat(16));
    let robot = "r".repeat(32);
    let mut builder = TableBuilder::new(&robot, &place);
    let name = "n".repeat(40);
    builder.declare::<Encoders>(&name, &name).unwrap();
    let table = builder.build().unwrap();
    let mut writer = table.writer::<Encoders>(&name, &name).unwrap();
    writer.write(1, &both(2.0));
    let inspector = Inspector::open(&robot, &place).unwrap();
    let mut reader = inspector.reader::<Encoders>(&name).unwrap();
    assert_eq!(reader.read().value, both(2.0));
    assert_eq!(inspector.directory()[0].owner, name);
}

#[test]
fn a_full_table_of_128_symbols_works() {
    let room = Room::new();
    let mut builder = TableBuilder::new("a", &room.place);
    for number in 0..128 {
        builder
            .declare::<Scan>("lidar", &format!("m{number}"))
            .unwrap();
    }
    let error = builder.declare::<Scan>("lidar", "one_more").unwrap_err();
    assert!(matches!(error, SymbolError::TooMany { .. }));
    let table = builder.build().unwrap();
    let mut writers: Vec<_> = (0..128)
        .map(|number| {
            table
                .writer::<Scan>("lidar", &format!("m{number}"))
                .unwrap()
        })
        .collect();
    let mut scan = Scan::zeroed();
    for (number, writer) in (1..).zip(&mut writers) {
        scan.ranges_mm = [number; 1024];
        writer.write(u64::from(number), &scan);
    }
    for number in 0..128 {
        let mut reader = table.reader::<Scan>("x", &format!("m{number}")).unwrap();
        assert_eq!(reader.read().value.ranges_mm, [number + 1; 1024]);
    }
}

#[test]
fn robots_in_one_place_do_not_meet() {
    let room = Room::new();
    let robots = ["a", "a_b", "a-1", "b"];
    let tables = robots.map(|robot| small_table(robot, &room.place));
    let mut writers = tables.each_ref().map(writer_of);
    for (stamp_ns, writer) in (1..).zip(&mut writers) {
        writer.write(stamp_ns, &both(stamp_ns as f64));
    }
    for (stamp_ns, robot) in (1..).zip(robots) {
        let inspector = Inspector::open(robot, &room.place).unwrap();
        let mut reader = inspector.reader::<Encoders>("drive").unwrap();
        assert_eq!(reader.read().stamp_ns, stamp_ns);
    }
    // One robot's end leaves the others alone.
    let words = room.words();
    let [first, rest @ ..] = tables;
    let [first_writer, rest_writers @ ..] = writers;
    drop((first, first_writer));
    assert!(Inspector::open("a", &room.place).is_err());
    for robot in &robots[1..] {
        Inspector::open(robot, &room.place).unwrap();
    }
    drop((rest, rest_writers));
    room.assert_nothing_left(&words);
}

fn writer_of(table: &SymbolTable) -> coordination::symbols::Writer<Encoders> {
    table.writer::<Encoders>("drive", "drive").unwrap()
}

#[test]
fn a_second_owner_is_refused_with_the_pid_and_changes_nothing() {
    let room = Room::new();
    let table = small_table("a", &room.place);
    let mut writer = writer_of(&table);
    writer.write(5, &both(5.0));
    let mut builder = TableBuilder::new("a", &room.place);
    builder.declare::<Encoders>("drive", "drive").unwrap();
    assert_eq!(
        builder.build().unwrap_err().to_string(),
        format!("robot `a` already runs (pid {})", std::process::id())
    );
    let error = coordination::symbols::remove_stale("a", &room.place).unwrap_err();
    assert!(matches!(
        error,
        SymbolError::AlreadyRuns { pid: Some(_), .. }
    ));
    let mut reader = table.reader::<Encoders>("x", "drive").unwrap();
    assert_eq!(reader.read().stamp_ns, 5);
}

#[test]
fn of_many_that_start_at_once_one_wins() {
    let room = Room::new();
    let start = Barrier::new(8);
    let build = || {
        let mut builder = TableBuilder::new("a", &room.place);
        builder.declare::<Encoders>("drive", "drive").unwrap();
        start.wait();
        builder.build()
    };
    let results: Vec<_> = thread::scope(|scope| {
        let threads: Vec<_> = (0..8).map(|_| scope.spawn(build)).collect();
        threads.into_iter().map(|t| t.join().unwrap()).collect()
    });
    let words = room.words();
    let (tables, errors): (Vec<_>, Vec<_>) = results.into_iter().partition(Result::is_ok);
    assert_eq!((tables.len(), words.len()), (1, 1));
    for error in errors {
        let error = error.unwrap_err();
        assert!(matches!(error, SymbolError::AlreadyRuns { .. }), "{error}");
    }
    drop(tables);
    room.assert_nothing_left(&words);
}

#[test]
fn nothing_stays_whatever_is_dropped_last() {
    for order in 0..3 {
        let room = Room::new();
        let table = small_table("a", &room.place);
        let words = room.words();
        assert_eq!(words.len(), 1);
        assert!(!shared_memory(&words).is_empty());
        let mut writer = writer_of(&table);
        let mut reader = table.reader::<Encoders>("x", "drive").unwrap();
        table.seal().unwrap_err();
        match order {
            0 => drop((writer, reader, table)),
            1 => {
                drop(table);
                writer.write(3, &both(3.0));
                assert_eq!(reader.read().stamp_ns, 3);
                assert!(Inspector::open("a", &room.place).is_ok(), "still owned");
                thread::spawn(move || drop(writer)).join().unwrap();
                drop(reader);
            }
            _ => {
                drop((table, writer));
                assert_eq!(reader.read().stamp_ns, 0);
                drop(reader);
            }
        }
        room.assert_nothing_left(&words);
    }
}

#[test]
fn a_robot_can_start_again_while_an_inspector_still_looks_at_its_past() {
    let room = Room::new();
    let table = small_table("a", &room.place);
    let mut words = room.words();
    let mut writer = writer_of(&table);
    writer.write(1, &both(1.0));
    let inspector = Inspector::open("a", &room.place).unwrap();
    let mut old = inspector.reader::<Encoders>("drive").unwrap();
    drop((table, writer));
    assert!(!inspector.is_alive());
    assert_eq!(old.read().stamp_ns, 1, "the last value stays readable");

    let table = small_table("a", &room.place);
    words.extend(room.words());
    let mut writer = writer_of(&table);
    writer.write(2, &both(2.0));
    assert!(!inspector.is_alive());
    let again = Inspector::open("a", &room.place).unwrap();
    let mut new = again.reader::<Encoders>("drive").unwrap();
    assert_eq!((old.read().stamp_ns, new.read().stamp_ns), (1, 2));
    drop((inspector, old));
    assert_eq!(new.read().stamp_ns, 2);
    drop((table, writer, new, again));
    room.assert_nothing_left(&words);
}

#[test]
fn inspectors_come_and_go() {
    let room = Room::new();
    let table = small_table("a", &room.place);
    let words = room.words();
    for _ in 0..100 {
        let inspector = Inspector::open("a", &room.place).unwrap();
        assert_eq!(inspector.directory().len(), 2);
    }
    let before = shared_memory(&words).len();
    let many: Vec<_> = (0..40)
        .map(|_| Inspector::open("a", &room.place).unwrap())
        .collect();
    drop(many);
    assert_eq!(shared_memory(&words).len(), before);
    drop(table);
    room.assert_nothing_left(&words);
}

#[test]
fn an_inspector_of_nothing_is_told_so() {
    let room = Room::new();
    let error = Inspector::open("a", &room.place).unwrap_err();
    assert!(matches!(
        error,
        SymbolError::NotRunning { dead_pid: None, .. }
    ));
    assert!(!room.root().exists(), "looking creates nothing");
    assert!(
        coordination::symbols::remove_stale("a", &room.place)
            .unwrap()
            .is_empty()
    );
    assert!(!room.root().exists());
}

/// Writers publish as fast as they can; no reader ever sees half of a value.
#[test]
fn values_are_never_torn() {
    let room = Room::new();
    let table = small_table("a", &room.place);
    let mut writer = table.writer::<Scan>("lidar", "front").unwrap();
    let stop = Arc::new(AtomicBool::new(false));
    let threads: Vec<_> = (0..3)
        .map(|number| {
            let mut reader = table
                .reader::<Scan>(&format!("r{number}"), "front")
                .unwrap();
            let stop = Arc::clone(&stop);
            thread::spawn(move || {
                let (mut last_ns, mut reads) = (0, 0_u64);
                while !stop.load(Ordering::Relaxed) {
                    let read = reader.read();
                    let expected = read.stamp_ns as u32;
                    assert!(read.value.ranges_mm.iter().all(|&range| range == expected));
                    assert!(read.stamp_ns >= last_ns, "time runs forward");
                    last_ns = read.stamp_ns;
                    reads += 1;
                }
                (reads, reader.retries())
            })
        })
        .collect();
    let mut scan = Scan::zeroed();
    for stamp_ns in 1..=20_000_u64 {
        scan.ranges_mm = [stamp_ns as u32; 1024];
        writer.write(stamp_ns, &scan);
        // Leaves the readers a chance: without a pause they would retry all the time.
        for _ in 0..200 {
            std::hint::spin_loop();
        }
    }
    stop.store(true, Ordering::Relaxed);
    let counts: Vec<_> = threads.into_iter().map(|t| t.join().unwrap()).collect();
    assert!(
        counts
            .iter()
            .all(|&(reads, retries)| reads > 0 && retries <= reads)
    );
    let retries: u64 = counts.iter().map(|&(_, retries)| retries).sum();
    assert!(
        retries > 0,
        "reads that met a write are counted: {counts:?}"
    );
}
