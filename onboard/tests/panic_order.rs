//! The hook of panics, in a process of its own: the robot stops before anything is said, and a real-time thread says nothing itself.

use std::io::{self, Write};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{Builder, JoinHandle};

use onboard::realtime::guard::real_time;
use onboard::realtime::panic::{Panicked, install_hook};

/// Where logs go: what was written, and whether the robot had been told to stop by then.
#[derive(Clone)]
struct Log {
    panicked: Panicked,
    written: Arc<Mutex<Vec<(bool, String)>>>,
}

impl Log {
    fn take(&self) -> Vec<(bool, String)> {
        let mut written = self.written.lock().unwrap_or_else(PoisonError::into_inner);
        std::mem::take(&mut *written)
    }
}

impl Write for Log {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let text = String::from_utf8_lossy(bytes).into_owned();
        let mut written = self.written.lock().unwrap_or_else(PoisonError::into_inner);
        written.push((self.panicked.is_raised(), text));
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn thread(name: &str, work: fn()) -> JoinHandle<()> {
    let thread = Builder::new().name(name.to_owned()).spawn(work);
    thread.expect("a thread")
}

#[test]
fn the_robot_is_stopped_before_a_panic_is_told_and_its_real_time_threads_leave_the_telling_to_others()
 {
    let panicked = Panicked::default();
    let log = Log {
        panicked: panicked.clone(),
        written: Arc::default(),
    };
    let writer = log.clone();
    tracing_subscriber::fmt()
        .with_writer(move || writer.clone())
        .init();
    install_hook(&panicked);
    tracing::info!("all is well");
    assert!(matches!(&log.take()[..], [(false, line)] if line.contains("all is well")));

    // What panics here on purpose comes back as an error.
    let ended = thread("communication", || panic!("a broken link")).join();
    let written = log.take();
    let [(raised, line)] = &written[..] else {
        panic!("{written:?}")
    };
    assert!(
        ended.is_err() && *raised,
        "said before the robot was told to stop"
    );
    let told = ["'communication'", "a broken link"];
    assert!(told.iter().all(|word| line.contains(word)), "{line}");
    assert_eq!(panicked.take_words(), None);

    let second = Panicked::default();
    install_hook(&second);
    let ended = thread("motion", || real_time(|| panic!("out of bounds"))).join();
    assert!(ended.is_err() && second.is_raised());
    assert_eq!(log.take(), []);
    let words = second.take_words().expect("they are kept");
    let told = ["'motion'", "out of bounds"];
    assert!(told.iter().all(|word| words.contains(word)), "{words}");
}
