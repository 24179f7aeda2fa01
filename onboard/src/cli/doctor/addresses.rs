//! The addresses of network interfaces, as the kernel lists them: whether a route leads to them or not.

use std::ffi::CStr;
use std::io;
use std::ptr::null_mut;

/// Whether an interface has an IPv4 address, under its own name or a label such as `eth0:1`.
///
/// # Errors
/// The system's; an interface that is not there has none.
pub fn has_ipv4(interface: &str) -> io::Result<bool> {
    let mut first: *mut libc::ifaddrs = null_mut();
    // SAFETY: makes `first` null or a list, which stays valid until it is freed below.
    if unsafe { libc::getifaddrs(&raw mut first) } != 0 {
        return Err(io::Error::last_os_error());
    }
    let mut found = false;
    let mut next: *const libc::ifaddrs = first;
    // SAFETY: `next` is null or an entry of that list.
    while let Some(entry) = unsafe { next.as_ref() } {
        // SAFETY: the address of an entry is null or one that lives as long as the list.
        let address = unsafe { entry.ifa_addr.as_ref() };
        // SAFETY: the name of an entry is a string that ends with zero.
        let name = unsafe { CStr::from_ptr(entry.ifa_name) };
        let is_ipv4 = address.is_some_and(|own| i32::from(own.sa_family) == libc::AF_INET);
        let unlabelled = name.to_bytes().split(|&byte| byte == b':').next();
        found |= is_ipv4 && unlabelled == Some(interface.as_bytes());
        next = entry.ifa_next;
    }
    // SAFETY: `first` came from `getifaddrs` and is freed once; nothing of it is kept.
    unsafe { libc::freeifaddrs(first) };
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loopback_has_an_address_and_what_is_not_there_has_none() {
        // Where somebody has taken it down there is nothing to see.
        if std::net::UdpSocket::bind("127.0.0.1:0").is_ok() {
            assert!(has_ipv4("lo").expect("it is told"));
        }
        assert!(!has_ipv4("no-such-one").expect("it is told"));
    }
}
