//! Proves that events, machines and symbols keep the real-time rules: with a counting allocator,
//! and with the kernel's strict filter of system calls.

mod counting;

use std::env;
use std::path::PathBuf;
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};

use bytemuck::Zeroable;
use coordination::activity::{LifeCycle, LifeCycleEvent};
use coordination::event::{EventTable, queue};
use coordination::fsm::MachineModel;
use coordination::symbols::{Namespace, Reader, SymbolTable, TableBuilder, Writer, remove_stale};
use counting::allocations;
use rustix::thread::{SecureComputingMode, gettid, set_secure_computing_mode};

#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Scan {
    ranges_mm: [u32; 1024],
}
coordination::datatype!(Scan, "range_scan");

#[test]
fn events_machines_and_life_cycles_do_not_allocate() {
    let mut events = EventTable::new();
    let mut model = MachineModel::new("m");
    model.state("a").state("b").initial("a");
    model.transition("a", "go", "b", &["x", "y"]);
    model.transition("b", "back", "a", &[]);
    let mut machine = model.compile(&mut events).unwrap();
    let inputs = ["go", "back", "x"].map(|name| events.id(name).unwrap());
    let mut life = LifeCycle::new();
    let (mut sender, mut receiver) = queue(4);
    let used = allocations(|| {
        for round in 0..1000 {
            for input in inputs {
                let step = machine.step(input);
                for &output in step.outputs {
                    let _ = sender.send(output);
                }
            }
            if round % 2 == 0 {
                receiver.receive();
            }
            for event in LifeCycleEvent::ALL.into_iter().rev() {
                life.step(event);
            }
        }
    });
    assert_eq!(used, 0);
    assert!(sender.refused() > 0 && machine.ignored() > 0 && life.ignored() > 0);
}

/// Allocations during ten thousand writes and reads of a scan.
fn use_symbols(writer: &mut Writer<Scan>, reader: &mut Reader<Scan>) -> u64 {
    let mut scan = Scan::zeroed();
    let (mut sum, mut retries) = (0, 0);
    let used = allocations(|| {
        for stamp_ns in 1..=10_000 {
            scan.ranges_mm[17] = stamp_ns as u32;
            writer.write(stamp_ns, &scan);
            let read = reader.read();
            sum += u64::from(read.value.ranges_mm[17]);
            retries = reader.retries();
        }
    });
    if sum == 10_000 * 10_001 / 2 && retries == 0 {
        used
    } else {
        u64::MAX
    }
}

fn handles(place: &Namespace) -> (SymbolTable, Writer<Scan>, Reader<Scan>) {
    let mut builder = TableBuilder::new("a", place);
    builder.declare::<Scan>("lidar", "front").unwrap();
    let table = builder.build().unwrap();
    let writer = table.writer::<Scan>("lidar", "front").unwrap();
    let reader = table.reader::<Scan>("tube", "front").unwrap();
    (table, writer, reader)
}

#[test]
fn symbols_do_not_allocate() {
    let folder = tempfile::tempdir().unwrap();
    let (_table, mut writer, mut reader) = handles(&Namespace::new(folder.path(), "rt_"));
    // Handles are made here and used in a thread of their own, as in a robot.
    let worker = std::thread::spawn(move || use_symbols(&mut writer, &mut reader));
    assert_eq!(worker.join().unwrap(), 0);
}

#[test]
fn added_symbols_do_not_allocate_and_say_whether_they_were_removed() {
    let folder = tempfile::tempdir().unwrap();
    let (table, ..) = handles(&Namespace::new(folder.path(), "rt_"));
    let mut writer = table.add::<Scan>("lidar", "rear").unwrap();
    let mut reader = table.reader::<Scan>("tube", "rear").unwrap();
    let worker = std::thread::spawn(move || {
        let used = use_symbols(&mut writer, &mut reader);
        let asking = allocations(|| assert!(!reader.is_removed()));
        used + asking
    });
    assert_eq!(worker.join().unwrap(), 0);
}

const ROLE: &str = "REAL_TIME_TEST_ROLE";
const ROOT: &str = "REAL_TIME_TEST_ROOT";

/// Not a test: what a child process does. Its thread may then do nothing but write.
#[test]
fn child() {
    let (Ok(role), Some(root)) = (env::var(ROLE), env::var_os(ROOT)) else {
        return;
    };
    let (_table, mut writer, mut reader) = handles(&Namespace::new(root, "rt_"));
    let done = Arc::new(AtomicBool::new(false));
    let worker_done = Arc::clone(&done);
    let (tell, told) = mpsc::channel();
    std::thread::spawn(move || {
        let stdout = rustix::stdio::stdout();
        tell.send(gettid()).unwrap();
        set_secure_computing_mode(SecureComputingMode::Strict).unwrap();
        // From here on the kernel ends this thread at any system call but read and write.
        if role == "forbidden" {
            std::thread::yield_now();
        }
        let line: &[u8] = match use_symbols(&mut writer, &mut reader) {
            0 => b"\nno system calls\n",
            _ => b"\nwrong\n",
        };
        let _ = rustix::io::write(stdout, line);
        worker_done.store(true, Ordering::Release);
        loop {
            // Ending would be a system call; the process ends around it.
            std::hint::spin_loop();
        }
    });
    // Until it is done, or ended by the kernel.
    let thread = PathBuf::from(format!("/proc/self/task/{}", told.recv().unwrap()));
    let deadline = Instant::now() + Duration::from_secs(60);
    while !done.load(Ordering::Acquire) && thread.exists() && Instant::now() < deadline {
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// What the child writes in this role.
fn child_output(role: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let output = Command::new(env::current_exe().unwrap())
        .args(["--exact", "child", "--nocapture", "--test-threads=1"])
        .env(ROLE, role)
        .env(ROOT, folder.path())
        .output()
        .unwrap();
    // The child ends while its thread still holds handles.
    remove_stale("a", &Namespace::new(folder.path(), "rt_")).unwrap();
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn symbols_make_no_system_calls() {
    let output = child_output("symbols");
    assert!(output.contains("\nno system calls\n"), "{output}");
}

#[test]
fn the_filter_ends_a_thread_that_makes_one() {
    let output = child_output("forbidden");
    assert!(!output.contains("no system calls"), "{output}");
}
