use std::fs;
use std::io::{Read, Write};
use std::os::unix::fs::{MetadataExt, PermissionsExt, chown, symlink};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};

use rustix::process::Uid;
use tempfile::TempDir;

use super::*;

/// `nobody`, on most machines.
const STRANGER: u32 = 65534;

/// A temporary folder, and a place in it where there is nothing.
fn place() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let place = folder.path().join("place");
    (folder, place)
}

fn made(path: &Path, mode: u32) {
    fs::create_dir(path).expect("made");
    set_mode(path, mode);
}

fn set_mode(path: &Path, mode: u32) {
    fs::set_permissions(path, fs::Permissions::from_mode(mode)).expect("it is ours");
}

fn mode(path: &Path) -> u32 {
    fs::symlink_metadata(path).expect("it is there").mode() & 0o7777
}

/// Whether this test may give files away; says so if not.
fn is_root() -> bool {
    let root = rustix::process::geteuid().is_root();
    if !root {
        eprintln!("skipped: only root can give files away and be another user");
    }
    root
}

/// What it was refused with, which must say all of this.
fn refused<T: std::fmt::Debug>(result: Result<T, PrivateError>, says: &[&str]) {
    let text = result.expect_err("it must be refused").to_string();
    for part in says {
        assert!(text.contains(part), "{part:?} is missing: {text}");
    }
}

#[test]
fn a_folder_and_those_above_it_are_made_private_and_used_again() {
    let (_temporary, place) = place();
    let inner = place.join("a/b");
    for _ in 0..2 {
        folder(&inner).expect("private");
        for made in [&place, &place.join("a"), &inner] {
            assert_eq!(mode(made), 0o700);
        }
    }
    // As it is written does not matter.
    folder(&place.join("a/./b/")).expect("the same");
}

#[test]
fn a_link_in_a_folders_place_is_refused_wherever_it_leads() {
    let (temporary, place) = place();
    let real = temporary.path().join("real");
    made(&real, 0o700);
    for target in [real.as_path(), Path::new("nowhere")] {
        symlink(target, &place).expect("a link");
        refused(folder(&place), &["is a symbolic link, expected a folder"]);
        // A slash at its end would follow it.
        let slash = PathBuf::from(format!("{}/", place.display()));
        refused(folder(&slash), &["is a symbolic link, expected a folder"]);
        refused(write(&place.join("file"), b"x"), &["is a symbolic link"]);
        refused(listen(&place.join("socket")), &["is a symbolic link"]);
        fs::remove_file(&place).expect("there");
    }
    assert_eq!(fs::read_dir(&real).expect("there").count(), 0);
    // A link above it is the machine's way to lay out its disks.
    symlink(&real, &place).expect("a link");
    folder(&place.join("inner")).expect("private");
}

#[test]
fn a_file_in_a_folders_place_is_refused() {
    let (_temporary, place) = place();
    fs::write(&place, "").expect("written");
    refused(folder(&place), &["is a file, expected a folder"]);
}

#[test]
fn a_folder_of_another_user_is_refused() {
    if !is_root() {
        return;
    }
    let (_temporary, place) = place();
    made(&place, 0o700);
    chown(&place, Some(STRANGER), None).expect("root may");
    let says = ["belongs to user 65534, expected user 0", "chown 0 "];
    refused(folder(&place), &says);
    refused(write(&place.join("file"), b"x"), &says);
    refused(listen(&place.join("socket")), &says);
}

#[test]
fn a_folder_that_is_open_to_others_is_refused_and_left_as_it_is() {
    let (_temporary, place) = place();
    made(&place, 0o700);
    for open in [0o755, 0o750, 0o701, 0o770, 0o1777] {
        set_mode(&place, open);
        let found = format!("has mode {open:04o}, expected 0700");
        let says = [found.as_str(), "chmod 0700 "];
        refused(folder(&place), &says);
        refused(write(&place.join("file"), b"x"), &says);
        refused(listen(&place.join("socket")), &says);
        assert_eq!(mode(&place), open);
    }
    assert_eq!(fs::read_dir(&place).expect("there").count(), 0);
}

#[test]
fn where_anybody_can_exchange_a_folder_it_is_refused() {
    let (_temporary, everybodys) = place();
    made(&everybodys, 0o777);
    let inner = everybodys.join("a/b");
    refused(folder(&inner), &["place has mode 0777", "chmod +t "]);
    set_mode(&everybodys, 0o1777);
    folder(&inner).expect("private: it is sticky");
    if !is_root() {
        return;
    }
    // In a sticky folder, too, owners of entries may exchange them.
    chown(everybodys.join("a"), Some(STRANGER), None).expect("root may");
    refused(folder(&inner), &["place/a belongs to user 65534"]);
}

#[test]
fn a_file_is_written_whole_with_its_mode_and_read_again() {
    let (_temporary, place) = place();
    folder(&place).expect("private");
    let file = place.join("key");
    assert!(read(&file).expect_err("there is none").is_missing());
    // What a killed process left is in nobody's way.
    fs::write(place.join(".key.new"), "half").expect("written");
    for text in ["first", "2"] {
        write(&file, text.as_bytes()).expect("written");
        assert_eq!(read(&file).expect("private"), text.as_bytes());
        assert_eq!(mode(&file), 0o600);
    }
    write_unsynced(&file, b"third").expect("written");
    assert_eq!(read(&file).expect("private"), b"third");
    assert_eq!(fs::read_dir(&place).expect("there").count(), 1);
    made(&place.join("taken"), 0o700);
    refused(
        write(&place.join("taken"), b"x"),
        &["cannot write", "taken"],
    );
    assert_eq!(fs::read_dir(&place).expect("there").count(), 2);
}

#[test]
fn a_secret_is_exchanged_where_others_look_and_may_not_change() {
    let (_temporary, place) = place();
    made(&place, 0o755);
    let secret = place.join("secret");
    refused(write(&secret, b"1"), &["place has mode 0755", "chmod 0700"]);
    replace(&secret, b"1").expect("nobody else can put anything there");
    assert_eq!((mode(&secret), mode(&place)), (0o600, 0o755));
    assert_eq!(read(&secret).expect("private"), b"1");
    for open in [0o775, 0o757, 0o1777] {
        set_mode(&place, open);
        refused(replace(&secret, b"2"), &["place has mode", "chmod 0755"]);
    }
    assert_eq!(fs::read(&secret).expect("it is there"), b"1");
}

#[test]
fn a_link_in_a_files_place_is_not_followed() {
    let (temporary, place) = place();
    folder(&place).expect("private");
    let (victim, link) = (temporary.path().join("victim"), place.join("key"));
    fs::write(&victim, "precious").expect("written");
    set_mode(&victim, 0o600);
    for target in [victim.clone(), temporary.path().join("nowhere")] {
        symlink(target, &link).expect("a link");
        refused(read(&link), &["is a symbolic link, expected a file"]);
        refused(open(&link), &["is a symbolic link, expected a file"]);
        refused(
            open_or_make(&link),
            &["is a symbolic link, expected a file"],
        );
        write(&link, b"key").expect("in place of the link");
        assert_eq!(read(&link).expect("a file now"), b"key");
        fs::remove_file(&link).expect("there");
    }
    assert_eq!(fs::read(&victim).expect("there"), b"precious");
    assert!(!temporary.path().join("nowhere").exists());
}

#[test]
fn a_secret_that_others_can_read_or_write_is_refused() {
    let (_temporary, place) = place();
    fs::write(&place, "key").expect("written");
    for open_mode in [0o640, 0o604, 0o620, 0o644] {
        set_mode(&place, open_mode);
        let found = format!("has mode {open_mode:04o}, expected 0600");
        refused(read(&place), &[&found, "chmod 0600 "]);
        open(&place).expect("who may read it does not matter here");
    }
    set_mode(&place, 0o400);
    assert_eq!(read(&place).expect("private"), b"key");
    if !is_root() {
        return;
    }
    chown(&place, Some(STRANGER), None).expect("root may");
    let says = ["belongs to user 65534, expected user 0"];
    refused(read(&place), &says);
    refused(open(&place), &says);
    refused(open_or_make(&place), &says);
}

#[test]
fn what_is_no_file_is_refused_and_holds_up_nobody() {
    let (temporary, place) = place();
    let pipe = temporary.path().join("pipe");
    let mode = rustix::fs::Mode::from_raw_mode(0o600);
    rustix::fs::mkfifoat(rustix::fs::CWD, &pipe, mode).expect("made");
    refused(read(&pipe), &["is a pipe, expected a file"]);
    refused(open_or_make(&pipe), &["is a pipe, expected a file"]);
    let _socket = UnixListener::bind(&place).expect("bound");
    refused(read(&place), &["is a socket, expected a file"]);
    refused(open(temporary.path()), &["is a folder, expected a file"]);
    refused(write(Path::new("/"), b"x"), &["/ is a folder"]);
}

#[test]
fn a_file_that_goes_on_being_written_is_made_private_where_nobody_can_exchange_it() {
    let (_temporary, everybodys) = place();
    made(&everybodys, 0o755);
    let file = everybodys.join("journal");
    drop(open_or_make(&file).expect("made"));
    assert_eq!(mode(&file), 0o600);
    open_or_make(&file).expect("used again");
    set_mode(&everybodys, 0o777);
    refused(open_or_make(&file), &["place has mode 0777"]);
    set_mode(&everybodys, 0o1777);
    open_or_make(&file).expect("it is sticky");
}

#[test]
fn a_socket_is_private_and_takes_the_place_of_one_that_is_left_over() {
    let (temporary, place) = place();
    folder(&place).expect("private");
    let path = place.join("amr-1.ctl");
    for _ in 0..2 {
        let listener = listen(&path).expect("listens");
        assert_eq!(mode(&path), 0o600);
        let mut client = UnixStream::connect(&path).expect("connects");
        let (mut served, _) = listener.accept().expect("accepts");
        peer(&served).expect("the same user");
        client.write_all(b"?").expect("written");
        let mut byte = [0];
        served.read_exact(&mut byte).expect("read");
        // The listener goes, its socket stays.
    }
    fs::remove_file(&path).expect("there");
    let victim = temporary.path().join("victim");
    fs::write(&victim, "precious").expect("written");
    symlink(&victim, &path).expect("a link");
    refused(listen(&path), &["is a symbolic link, expected a socket"]);
    fs::remove_file(&path).expect("there");
    fs::write(&path, "precious").expect("written");
    refused(listen(&path), &["is a file, expected a socket"]);
    assert_eq!(fs::read(&victim).expect("there"), b"precious");
}

#[test]
fn another_user_at_the_other_end_is_refused() {
    if !is_root() {
        return;
    }
    let (temporary, place) = place();
    folder(&place).expect("private");
    let path = place.join("amr-1.ctl");
    let listener = listen(&path).expect("listens");
    let connect = |path: PathBuf| {
        // The system call itself, which is for one thread.
        std::thread::spawn(move || {
            let stranger = Uid::from_raw(STRANGER);
            rustix::thread::set_thread_res_uid(stranger, stranger, stranger).expect("root may");
            UnixStream::connect(path)
        })
        .join()
        .expect("ends")
    };
    // The folder keeps it out, and so does the socket.
    let error = connect(path.clone()).expect_err("it is kept out");
    assert_eq!(error.kind(), std::io::ErrorKind::PermissionDenied);
    set_mode(temporary.path(), 0o755);
    set_mode(&place, 0o755);
    assert!(connect(path.clone()).is_err());
    // Where somebody has opened both.
    set_mode(&path, 0o666);
    let _client = connect(path).expect("connects");
    let (served, _) = listener.accept().expect("accepts");
    let says = ["user 65534 may not ask, only user 0 and root"];
    refused(peer(&served), &says);
}
