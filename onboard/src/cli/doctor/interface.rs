//! The network interface of the fieldbus: there, up, without an address, without other users, without a wait for more frames.

use std::io;
use std::path::Path;

use super::addresses::has_ipv4;
use super::computer::{Computer, Program, end_rivals, is_one_robot, listed};
use super::ethtool::{Coalescing, coalescing};
use super::finding::Finding;

/// Programs that configure every interface they find.
const MANAGERS: [&str; 4] = ["NetworkManager", "dhcpcd", "dhclient", "connmand"];
/// EtherCAT's protocol number, as `/proc/net/packet` writes it.
const ETHERCAT: &str = "88a4";
/// A frame may wait in the interface for so long; a cycle has 1000 µs.
const LONGEST_WAIT_US: u32 = 20;

/// All of them.
pub fn findings(computer: &Computer, interface: &str) -> Vec<Finding> {
    let folder = format!("/sys/class/net/{interface}");
    if !computer.has(&folder) {
        let others = computer.names("/sys/class/net").join(", ");
        let finding = Finding::bad(
            "interface",
            format!("there is no {interface}; there are {others}"),
            "ethercat.interface names the one that the drive is on",
        );
        return vec![finding.with("ip -brief link   # which has a carrier, and no address?")];
    }
    let mut found = vec![link(computer, interface, &folder)];
    found.push(addresses(computer, interface, has_ipv4(interface)));
    found.push(other_users(computer, interface, &folder));
    found.push(managers(computer, interface));
    found.push(waits(interface));
    found
}

fn link(computer: &Computer, interface: &str, folder: &str) -> Finding {
    const SUBJECT: &str = "interface";
    const UP: u32 = 1;
    let flags = computer.text(&format!("{folder}/flags"));
    let flags = flags.and_then(|text| u32::from_str_radix(text.trim_start_matches("0x"), 16).ok());
    if flags.is_none_or(|flags| flags & UP == 0) {
        return Finding::bad(SUBJECT, format!("{interface} is down"), "up")
            .with(format!("sudo ip link set {interface} up"));
    }
    if computer.number(&format!("{folder}/carrier")) != Some(1) {
        return Finding::bad(
            SUBJECT,
            format!("{interface} has no carrier"),
            "a cable that is plugged in at both ends, to a drive that has power",
        )
        .with(format!(
            "ip -brief link show {interface}   # then says LOWER_UP"
        ));
    }
    let speed = computer
        .number::<i64>(&format!("{folder}/speed"))
        .filter(|&speed| speed > 0);
    match speed {
        Some(100) | None => Finding::good(SUBJECT, format!("{interface} is up")),
        Some(speed) => Finding::weak(
            SUBJECT,
            format!("{interface} is up at {speed} Mbit/s"),
            "100 Mbit/s, which is EtherCAT's: plug in the drive, with nothing between",
        )
        .with(format!(
            "sudo ethtool -s {interface} speed 100 duplex full autoneg on   # if it is the drive"
        )),
    }
}

/// An interface with an address sends frames of others, which the segment carries round.
fn addresses(computer: &Computer, interface: &str, has_ipv4: io::Result<bool>) -> Finding {
    const SUBJECT: &str = "no IP on the bus";
    const SHOULD: &str = "an interface for frames of the bus alone";
    let ipv6 = computer.text("/proc/net/if_inet6").unwrap_or_default();
    let ipv6 = ipv6
        .lines()
        .any(|line| line.split_whitespace().last() == Some(interface));
    let is = match (has_ipv4, ipv6) {
        (Ok(false), false) => {
            return Finding::good(SUBJECT, format!("{interface} has no address"));
        }
        (Err(error), false) => {
            let is = format!("whether {interface} has an IPv4 address is not told: {error}");
            let finding = Finding::unknown(SUBJECT, is, SHOULD);
            return finding.with(format!("ip -brief address show {interface}"));
        }
        (Ok(true), false) => "an IPv4 address",
        (Ok(false) | Err(_), true) => "an IPv6 address",
        (Ok(true), true) => "IPv4 and IPv6",
    };
    Finding::weak(SUBJECT, format!("{interface} has {is}"), SHOULD).with(format!(
        "sudo ip addr flush dev {interface} && sudo sysctl -w net.ipv6.conf.{interface}.disable_ipv6=1"
    ))
}

fn other_users(computer: &Computer, interface: &str, folder: &str) -> Finding {
    const SUBJECT: &str = "bus to itself";
    let index = computer
        .text(&format!("{folder}/ifindex"))
        .unwrap_or_default();
    let packet = computer.text("/proc/net/packet").unwrap_or_default();
    // sk RefCnt Type Proto Iface R Rmem User Inode
    let inodes: Vec<&str> = packet
        .lines()
        .skip(1)
        .map(|line| line.split_whitespace().collect::<Vec<_>>())
        .filter(|fields| fields.get(3) == Some(&ETHERCAT) && fields.get(4) == Some(&index.as_str()))
        .filter_map(|fields| fields.get(8).copied())
        .collect();
    if inodes.is_empty() {
        return Finding::good(SUBJECT, "nobody else sends EtherCAT frames");
    }
    let users = |inode: &&str| {
        let socket = format!("socket:[{inode}]");
        computer.who_has_open(|path| path == Path::new(&socket))
    };
    let users: Vec<Vec<Program>> = inodes.iter().map(users).collect();
    // Sockets of all users are told, but not who has those of others.
    let is_one_unseen = users.iter().any(Vec::is_empty);
    let mut programs: Vec<Program> = users.into_iter().flatten().collect();
    programs.sort_by_key(|own| own.pid);
    programs.dedup();
    if !is_one_unseen && is_one_robot(&programs) {
        return Finding::unknown(
            SUBJECT,
            format!("{} drives by it", listed(&programs)),
            "this robot alone: look again when it is stopped",
        );
    }
    let mut who = listed(&programs);
    if is_one_unseen {
        who.push_str(if who.is_empty() { "" } else { ", " });
        who.push_str("a program that this user does not see");
    }
    let verb = match programs.len() + usize::from(is_one_unseen) {
        1 => "sends",
        _ => "send",
    };
    let finding = Finding::bad(
        SUBJECT,
        format!("{who} {verb} EtherCAT frames on {interface}"),
        "one MainDevice on a segment",
    );
    finding.with(if is_one_unseen {
        "sudo ss --packet --processes   # whose it is".to_owned()
    } else {
        end_rivals(&programs)
    })
}

fn managers(computer: &Computer, interface: &str) -> Finding {
    const SUBJECT: &str = "network managers";
    let running = MANAGERS
        .into_iter()
        .filter_map(|name| computer.runs(name))
        .filter(|own| own.name != "NetworkManager" || !is_left_alone(computer, interface))
        .collect::<Vec<_>>();
    match running.first() {
        None => Finding::good(SUBJECT, "none that gives addresses by itself"),
        Some(first) => Finding::weak(
            SUBJECT,
            format!(
                "{} runs, and may give {interface} an address",
                listed(&running)
            ),
            "told to leave the bus alone",
        )
        .with(match first.name.as_str() {
            "NetworkManager" => format!("sudo nmcli device set {interface} managed no"),
            "dhcpcd" => format!("echo denyinterfaces {interface} | sudo tee -a /etc/dhcpcd.conf"),
            name => format!("sudo systemctl disable --now {name}"),
        }),
    }
}

/// NetworkManager was told to.
fn is_left_alone(computer: &Computer, interface: &str) -> bool {
    let index = computer.text(&format!("/sys/class/net/{interface}/ifindex"));
    let told =
        index.and_then(|index| computer.text(&format!("/run/NetworkManager/devices/{index}")));
    told.is_some_and(|text| text.lines().any(|line| line == "managed=false"))
}

/// Interfaces that save interrupts keep a frame until more have come or time has passed.
fn waits(interface: &str) -> Finding {
    const SUBJECT: &str = "waits for more";
    match coalescing(interface) {
        Ok(None) => Finding::good(SUBJECT, format!("{interface} tells of each frame at once")),
        Ok(Some(Coalescing {
            receive_us,
            send_us,
            ..
        })) => {
            let is = format!(
                "a frame waits for up to {receive_us} µs when it comes, and {send_us} µs when it goes"
            );
            if receive_us.max(send_us) <= LONGEST_WAIT_US {
                Finding::good(SUBJECT, is)
            } else {
                // One at a time: an interface that has only one of them refuses both at once.
                Finding::weak(SUBJECT, is, format!("at most {LONGEST_WAIT_US} µs")).with(format!(
                    "sudo ethtool -C {interface} rx-usecs 0; sudo ethtool -C {interface} tx-usecs 0"
                ))
            }
        }
        Err(error) => Finding::unknown(
            SUBJECT,
            format!("{interface} does not tell: {error}"),
            format!("at most {LONGEST_WAIT_US} µs"),
        )
        .with(format!("sudo ethtool -c {interface}")),
    }
}

#[cfg(test)]
mod tests {
    use super::super::computer::tests::Fake;
    use super::super::finding::Verdict;
    use super::*;

    const FOLDER: &str = "/sys/class/net/eth0";

    fn up() -> Fake {
        Fake::new()
            .with("/sys/class/net/eth0/flags", "0x1003\n")
            .with("/sys/class/net/eth0/carrier", "1\n")
            .with("/sys/class/net/eth0/speed", "100\n")
            .with("/sys/class/net/eth0/ifindex", "2\n")
    }

    #[test]
    fn an_interface_is_up_with_a_cable_at_the_speed_of_ethercat() {
        let of = |fake: &Fake| link(&fake.computer(), "eth0", FOLDER);
        assert_eq!(of(&up()).verdict, Verdict::Good);
        let down = of(&up().with("/sys/class/net/eth0/flags", "0x1002\n"));
        assert_eq!(down.command.as_deref(), Some("sudo ip link set eth0 up"));
        let loose = of(&up().with("/sys/class/net/eth0/carrier", "0\n"));
        assert!(loose.verdict == Verdict::Bad && loose.command.is_some());
        let fast = of(&up().with("/sys/class/net/eth0/speed", "1000\n"));
        assert!(fast.verdict == Verdict::Weak && fast.command.is_some());
        let missing = findings(&up().computer(), "eth7");
        assert!(missing[0].is.contains("there are eth0"), "{}", missing[0]);
    }

    #[test]
    fn addresses_of_either_kind_are_seen() {
        let clean = up();
        let local = "fe800000000000000000000000000001 02 40 20 80     eth0\n";
        let with_ipv6 = up().with("/proc/net/if_inet6", local);
        let of = |fake: &Fake, interface: &str, has_ipv4: io::Result<bool>| {
            let found = addresses(&fake.computer(), interface, has_ipv4);
            (found.verdict, found.is)
        };
        assert_eq!(of(&clean, "eth0", Ok(false)).0, Verdict::Good);
        let weak = |is: &str| (Verdict::Weak, format!("eth0 has {is}"));
        // It has no route.
        assert_eq!(of(&clean, "eth0", Ok(true)), weak("an IPv4 address"));
        assert_eq!(of(&with_ipv6, "eth0", Ok(false)), weak("an IPv6 address"));
        assert_eq!(of(&with_ipv6, "eth0", Ok(true)), weak("IPv4 and IPv6"));
        assert_eq!(of(&with_ipv6, "eth1", Ok(false)).0, Verdict::Good);
        let untold = || -> io::Result<bool> { Err(io::ErrorKind::PermissionDenied.into()) };
        assert_eq!(of(&clean, "eth0", untold()).0, Verdict::Unknown);
        assert_eq!(of(&with_ipv6, "eth0", untold()), weak("an IPv6 address"));
    }

    #[test]
    fn another_main_device_is_named() {
        let packet = "sk       RefCnt Type Proto  Iface R Rmem   User   Inode\n\
                      000000 3      3    88a4   2     1 0      0      4711\n\
                      000000 3      3    0003   2     1 0      0      4712\n";
        let fake = up()
            .with("/proc/net/packet", packet)
            .with("/proc/40/comm", "ec_master\n")
            .linking("/proc/40/fd/5", "socket:[4711]");
        let found = other_users(&fake.computer(), "eth0", FOLDER);
        assert_eq!(found.verdict, Verdict::Bad);
        assert!(found.is.starts_with("ec_master (40) sends"), "{found}");
        assert_eq!(found.command.as_deref(), Some("sudo kill 40"));
        let elsewhere = fake.with("/sys/class/net/eth0/ifindex", "3\n");
        assert_eq!(
            other_users(&elsewhere.computer(), "eth0", FOLDER).verdict,
            Verdict::Good
        );
    }

    #[test]
    fn a_robot_that_runs_is_no_rival_of_itself() {
        let packet = "sk RefCnt Type Proto Iface R Rmem User Inode\n0 3 3 88a4 2 1 0 0 4711\n";
        let fake = up()
            .with("/proc/net/packet", packet)
            .with("/proc/40/comm", "onboard\n")
            .linking("/proc/40/fd/5", "socket:[4711]");
        let found = other_users(&fake.computer(), "eth0", FOLDER);
        assert_eq!(found.verdict, Verdict::Unknown);
        assert_eq!(found.is, "onboard (40) drives by it");
    }

    #[test]
    fn whoever_is_beside_a_robot_that_runs_is_its_rival() {
        let packet = "sk RefCnt Type Proto Iface R Rmem User Inode\n\
                      0 3 3 88a4 2 1 0 0 4711\n\
                      0 3 3 88a4 2 1 0 0 4712\n";
        let of = |fake: &Fake| {
            let found = other_users(&fake.computer(), "eth0", FOLDER);
            assert_eq!(found.verdict, Verdict::Bad, "{found}");
            (found.is, found.command.expect("one that helps"))
        };
        let robot = || {
            up().with("/proc/net/packet", packet)
                .with("/proc/40/comm", "onboard\n")
                .linking("/proc/40/fd/5", "socket:[4711]")
        };
        let beside = |name: &str| {
            of(&robot()
                .with("/proc/41/comm", name)
                .linking("/proc/41/fd/5", "socket:[4712]"))
        };
        let (is, command) = beside("ec_master\n");
        assert_eq!(
            is,
            "onboard (40), ec_master (41) send EtherCAT frames on eth0"
        );
        assert_eq!(command, "sudo kill 41");
        let (is, command) = beside("onboard\n");
        assert!(is.starts_with("onboard (40), onboard (41) send "), "{is}");
        assert!(command.starts_with("ps -o pid,user,args -p 40,41"));
        let (is, command) = of(&robot());
        assert!(
            is.starts_with("onboard (40), a program that this user does not see send "),
            "{is}"
        );
        assert!(command.starts_with("sudo ss "), "{command}");
        let (is, _) = of(&up().with("/proc/net/packet", packet));
        assert!(is.starts_with("a program that this user does not see sends "));
    }

    #[test]
    fn a_manager_is_told_unless_it_leaves_the_bus_alone() {
        let fake = up().with("/proc/5/comm", "NetworkManager\n");
        let command = managers(&fake.computer(), "eth0").command;
        assert_eq!(
            command.as_deref(),
            Some("sudo nmcli device set eth0 managed no")
        );
        let told = "[device]\nmanaged=false\n";
        let fake = fake.with("/run/NetworkManager/devices/2", told);
        assert_eq!(managers(&fake.computer(), "eth0").verdict, Verdict::Good);
    }
}
