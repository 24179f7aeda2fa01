//! Keeps cores out of sleeps from which they wake late, through the kernel's device for that
//! (`Documentation/power/pm_qos_interface.rst`): a demand holds as long as the file is open.

use std::fs::{File, OpenOptions};
use std::io::{self, Write};

/// Where the longest wake-up is said, in µs.
pub const DEVICE: &str = "/dev/cpu_dma_latency";

/// The demand that cores wake at once, until it is dropped.
#[derive(Debug)]
pub struct AwakeCores(#[expect(dead_code, reason = "open as long as it is kept")] File);

fn open() -> io::Result<File> {
    OpenOptions::new().write(true).open(DEVICE)
}

/// Demands it.
///
/// # Errors
/// The system's; without rights to the device, or without the device, cores sleep as they like.
pub fn keep_cores_awake() -> io::Result<AwakeCores> {
    let mut device = open()?;
    device.write_all(&0_i32.to_ne_bytes())?;
    Ok(AwakeCores(device))
}

/// Whether it may be demanded. Opening alone demands nothing.
///
/// # Errors
/// As of [`keep_cores_awake`].
pub fn may_forbid() -> io::Result<()> {
    open().map(drop)
}
