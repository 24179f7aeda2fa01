//! What a running robot keeps from other users of its computer.

use std::fs::{self, Permissions};
use std::io::{BufRead, BufReader, Write};
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};

use onboard::process::runtime::Runtime;
use rustix::process::Uid;

use crate::programs::bench::{Bench, ROBOT, onboard, said};
use crate::programs::late::once_more_if_late;

/// The runtime folder, what is in it, and the shared memory; those below that are folders let nobody in.
fn made(bench: &Bench) -> Vec<PathBuf> {
    let folder = bench.runtime_folder();
    let prefix = Runtime::new(Some(folder.clone()))
        .expect("the runtime folder")
        .place()
        .prefix;
    let list = |folder: &Path| fs::read_dir(folder).expect("readable").flatten();
    let shared = list(Path::new("/dev/shm"))
        .filter(|entry| entry.file_name().to_string_lossy().contains(&prefix));
    let own = list(&folder).chain(shared).map(|entry| entry.path());
    own.chain([folder.clone()]).collect()
}

fn nobody_else_reaches(made: &[PathBuf]) {
    for path in made {
        let found = match fs::symlink_metadata(path) {
            Ok(found) => found,
            // A checkpoint that was replaced by a newer one.
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => continue,
            Err(error) => panic!("{}: {error}", path.display()),
        };
        let mode = found.mode();
        assert_eq!(mode & 0o077, 0, "{mode:o} {}", path.display());
    }
}

#[test]
fn nobody_else_reaches_what_a_running_robot_makes_and_the_same_user_does() {
    once_more_if_late(|| {
        let bench = Bench::driving();
        let all = made(&bench);
        nobody_else_reaches(&all);
        let folder = bench.runtime_folder();
        for name in ["ctl", "checkpoint", "journey"] {
            let path = folder.join(format!("{ROBOT}.{name}"));
            assert!(all.contains(&path), "{} is missing", path.display());
        }
        let shared = { all.iter() }.filter(|path| path.parent() == Some(Path::new("/dev/shm")));
        assert!(shared.count() >= 3, "{all:?}");

        let runtime = folder.display().to_string();
        let inspect = onboard(&["inspect", "--robot", ROBOT, "--runtime", &runtime]);
        assert!(inspect.status.success(), "{}", said(&inspect));
        nobody_else_reaches(&made(&bench));
        is_refused_for_another_user(&bench);
        bench.ask("pause");
        bench.finish();
    });
}

/// Even where somebody has opened the folders and the socket.
fn is_refused_for_another_user(bench: &Bench) {
    if !rustix::process::geteuid().is_root() {
        eprintln!("left out: only root can be another user");
        return;
    }
    let folder = bench.runtime_folder();
    let socket = folder.join(format!("{ROBOT}.ctl"));
    let above = folder.parent().expect("the bench's own").to_owned();
    let set = |modes: [u32; 3]| {
        for (path, mode) in [&above, &folder, &socket].into_iter().zip(modes) {
            fs::set_permissions(path, Permissions::from_mode(mode)).expect("it is ours");
        }
    };
    let ask = |socket: PathBuf| {
        std::thread::spawn(move || {
            // The system call itself, which is for one thread.
            let uid = Uid::from_raw(65534);
            rustix::thread::set_thread_res_uid(uid, uid, uid).expect("root may");
            let mut stream = UnixStream::connect(socket)?;
            writeln!(stream, "stop")?;
            let mut answer = String::new();
            BufReader::new(stream).read_line(&mut answer)?;
            Ok::<_, std::io::Error>(answer)
        })
        .join()
        .expect("ends")
    };
    let error = ask(socket.clone()).expect_err("the folder keeps it out");
    assert_eq!(error.kind(), std::io::ErrorKind::PermissionDenied);
    set([0o755, 0o755, 0o666]);
    let answer = ask(socket.clone()).expect("answered");
    assert_eq!(
        answer,
        "refused: user 65534 may not ask, only user 0 and root\n"
    );
    set([0o700, 0o700, 0o600]);
}
