//! The interrupt by which frames of the fieldbus come. On a kernel for real time a thread serves it.

use super::computer::{Computer, Program};
use super::finding::Finding;

/// Field of `/proc/PID/stat` behind the name: the 40th of all (proc(5)).
const RT_PRIORITY: usize = 37;

/// `priority`: the highest that the robot's threads want.
pub fn finding(computer: &Computer, interface: &str, priority: Option<u8>) -> Finding {
    const SUBJECT: &str = "its interrupt";
    let table = computer.text("/proc/interrupts").unwrap_or_default();
    let controller = usb_controller(computer, interface);
    let numbers: Vec<&str> = { table.lines() }
        .filter(|line| is_of(line, interface, controller.as_deref()))
        .filter_map(|line| line.split(':').next().map(str::trim))
        .collect();
    if numbers.is_empty() {
        return Finding::unknown(
            SUBJECT,
            format!("none by the name of {interface}, or of its USB controller"),
        );
    }
    let cores =
        |number: &&str| computer.text(&format!("/proc/irq/{number}/effective_affinity_list"));
    let mut cores: Vec<String> = numbers.iter().filter_map(cores).collect();
    cores.sort();
    cores.dedup();
    let is = format!("{} on cores {}", numbers.join(", "), cores.join(", "));
    let wanted = i64::from(priority.unwrap_or(0));
    let threads = computer.programs();
    let mut served = { threads.iter() }.filter(|thread| serves(thread, &numbers));
    let behind = served.find(|thread| rt_priority(computer, thread) <= Some(wanted));
    match behind {
        Some(thread) => Finding::weak(
            SUBJECT,
            format!("{is}; its thread comes after those of the robot that wait for frames"),
            format!("a priority above {wanted}"),
        )
        .with(format!(
            "sudo chrt -f -p {} {}",
            (wanted + 5).min(98),
            thread.pid
        )),
        None => Finding::good(SUBJECT, is),
    }
}

/// As `/proc/interrupts` names it, `usb3`; none where the interface is not on USB.
fn usb_controller(computer: &Computer, interface: &str) -> Option<String> {
    let link = computer.link(&format!("/sys/class/net/{interface}"))?;
    let mut parts = link
        .components()
        .map(|part| part.as_os_str().to_string_lossy());
    let is_bus = |part: &str| {
        let number = part.strip_prefix("usb");
        number.is_some_and(|own| !own.is_empty() && own.bytes().all(|byte| byte.is_ascii_digit()))
    };
    parts
        .find(|part| is_bus(part))
        .map(|part| part.into_owned())
}

/// A line of `/proc/interrupts` ends with who is served: an interface, one of its queues, or a controller and its bus.
fn is_of(line: &str, interface: &str, controller: Option<&str>) -> bool {
    let action = line.split_whitespace().last().unwrap_or_default();
    let queue = action.strip_prefix(interface);
    let bus = action.rsplit_once(':').map(|(_, bus)| bus);
    action == interface
        || queue.is_some_and(|rest| rest.starts_with('-'))
        || controller.is_some() && bus == controller
}

fn serves(thread: &Program, numbers: &[&str]) -> bool {
    let rest = thread.name.strip_prefix("irq/");
    let number = rest.and_then(|rest| rest.split('-').next());
    number.is_some_and(|number| numbers.contains(&number))
}

fn rt_priority(computer: &Computer, thread: &Program) -> Option<i64> {
    let stat = computer.text(&format!("/proc/{}/stat", thread.pid))?;
    let (_, fields) = stat.rsplit_once(") ")?;
    fields.split(' ').nth(RT_PRIORITY)?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::super::computer::tests::Fake;
    use super::super::finding::Verdict;
    use super::*;

    #[test]
    fn an_interrupt_is_found_by_its_interface() {
        let fake = Fake::new()
            .with("/proc/interrupts", "           CPU0       CPU1\n 24:  1  0  PCI-MSI  eth0-rx-0\n 25:  0  3  PCI-MSI  wlan0\n")
            .with("/proc/irq/24/effective_affinity_list", "1\n");
        let of = |interface| finding(&fake.computer(), interface, Some(80));
        assert_eq!(of("eth0").is, "24 on cores 1");
        assert_eq!(of("eth1").verdict, Verdict::Unknown);
    }

    /// As on the ODROID XU4.
    #[test]
    fn one_of_usb_is_its_controllers_and_its_thread_must_come_first() {
        let stat = |priority: u8| {
            let fields: Vec<String> = (3..=52)
                .map(|field| {
                    if field == 40 {
                        priority.to_string()
                    } else {
                        "0".to_owned()
                    }
                })
                .collect();
            format!("71 (irq/71-xhci-hcd) {}\n", fields.join(" "))
        };
        let of = |priority: u8| {
            let fake = Fake::new()
                .with("/proc/interrupts", "  CPU0\n 71: 5 GICv2 105 Level xhci-hcd:usb3\n 72: 5 GICv2 106 Level xhci-hcd:usb33\n")
                .linking("/sys/class/net/eth0", "../../devices/platform/soc/12110000.usb/xhci-hcd.2.auto/usb3/3-1/3-1:1.0/net/eth0")
                .with("/proc/irq/71/effective_affinity_list", "0-3\n")
                .with("/proc/60/comm", "irq/71-xhci-hcd\n")
                .with("/proc/60/stat", &stat(priority));
            finding(&fake.computer(), "eth0", Some(80))
        };
        assert_eq!(
            (of(85).verdict, of(85).is),
            (Verdict::Good, "71 on cores 0-3".to_owned())
        );
        let behind = of(50);
        assert_eq!(behind.verdict, Verdict::Weak);
        assert_eq!(behind.command.as_deref(), Some("sudo chrt -f -p 85 60"));
    }
}
