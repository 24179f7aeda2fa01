//! What this program may do: real-time priority, locked memory, raw frames. Tried, not read from settings.

use description::robot::Link;

use super::finding::Finding;
use crate::realtime::memory::{MemoryLock, lock_memory};
use crate::realtime::scheduling::{CoreClass, Wanted, try_out};

/// Gives the program all rights that it takes, once nobody but its group may run it.
const GRANT: &str = "sudo groupadd --system --force robots && sudo usermod --append --groups robots \"$USER\" && \
    sudo chown root:robots \"$(command -v onboard)\" && sudo chmod 0750 \"$(command -v onboard)\" && \
    sudo setcap cap_net_raw,cap_sys_nice,cap_ipc_lock+ep \"$(command -v onboard)\"";

/// All of them. `priority`: the highest that the robot's threads want.
pub fn findings(link: &Link, priority: Option<u8>) -> Vec<Finding> {
    let mut found = Vec::new();
    if let Some(priority) = priority {
        found.push(real_time_priority(priority, link));
    }
    found.push(locked_memory());
    if let Link::Interface(interface) = link {
        found.push(raw_frames(interface));
    }
    found
}

fn real_time_priority(priority: u8, link: &Link) -> Finding {
    const SUBJECT: &str = "real-time priority";
    let wanted = Wanted {
        fifo_priority: Some(priority),
        cores: CoreClass::Any,
    };
    match try_out(&wanted) {
        Ok(()) => Finding::good(SUBJECT, format!("FIFO {priority} is granted")),
        Err(why) => {
            let judge = match link {
                Link::Interface(_) => Finding::bad,
                Link::Udp(_) => Finding::weak,
            };
            judge(SUBJECT, why, format!("FIFO {priority}")).with(GRANT)
        }
    }
}

fn locked_memory() -> Finding {
    const SUBJECT: &str = "locked memory";
    match lock_memory() {
        MemoryLock::Locked => Finding::good(SUBJECT, "pages stay in memory"),
        MemoryLock::NotLocked(why) => {
            Finding::weak(SUBJECT, why, "memory that is never swapped out").with(GRANT)
        }
    }
}

fn raw_frames(interface: &str) -> Finding {
    const SUBJECT: &str = "raw frames";
    match drivers::ethercat::RawLink::open(interface) {
        Ok(_) => Finding::good(SUBJECT, format!("may be sent on {interface}")),
        Err(error) => {
            Finding::bad(SUBJECT, error.to_string(), "a socket for EtherCAT frames").with(GRANT)
        }
    }
}
