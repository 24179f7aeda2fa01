//! The interrupt by which frames of the fieldbus come: on which cores. On a kernel for real time a thread serves it.

use super::computer::{Computer, Program};
use super::finding::Finding;

/// Field of `/proc/PID/stat` behind the name: the 40th of all (proc(5)).
const RT_PRIORITY: usize = 37;

/// All of them. `priority`: the highest that the robot's threads want; `slow`: cores that are for those that may wait.
pub fn findings(
    computer: &Computer,
    interface: &str,
    priority: Option<u8>,
    slow: &[usize],
) -> Vec<Finding> {
    const SUBJECT: &str = "its interrupt";
    let table = computer.text("/proc/interrupts").unwrap_or_default();
    let controller = usb_controller(computer, interface);
    let numbers: Vec<&str> = { table.lines() }
        .filter(|line| is_of(line, interface, controller.as_deref()))
        .filter_map(|line| line.split(':').next().map(str::trim))
        .collect();
    if numbers.is_empty() {
        let is = format!("none by the name of {interface}, or of its USB controller");
        let should = "one that comes before the robot's threads";
        let finding = Finding::unknown(SUBJECT, is, should);
        return vec![finding.with("cat /proc/interrupts   # which one counts while frames come?")];
    }
    vec![
        comes_first(computer, &numbers, priority),
        place(computer, &numbers, slow),
    ]
}

/// Its thread, where it has one, comes before those of the robot that wait for frames.
fn comes_first(computer: &Computer, numbers: &[&str], priority: Option<u8>) -> Finding {
    const SUBJECT: &str = "its interrupt";
    let is = numbers.join(", ");
    let wanted = i64::from(priority.unwrap_or(0));
    let threads = computer.programs();
    let mut served = { threads.iter() }.filter(|thread| serves(thread, numbers));
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

/// On a computer with slow cores these serve it, so that it takes no time from threads that have a fast one each.
fn place(computer: &Computer, numbers: &[&str], slow: &[usize]) -> Finding {
    const SUBJECT: &str = "its cores";
    let (mut lists, mut elsewhere) = (Vec::new(), Vec::new());
    for number in numbers {
        let folder = format!("/proc/irq/{number}");
        let list = computer.text(&format!("{folder}/effective_affinity_list"));
        let is_slow = |list: &String| cores_of(list).iter().all(|core| slow.contains(core));
        if !list.as_ref().is_some_and(is_slow) {
            elsewhere.push(format!("{folder}/smp_affinity_list"));
        }
        lists.extend(list);
    }
    lists.sort();
    lists.dedup();
    if lists.is_empty() {
        return Finding::unknown(
            SUBJECT,
            "the kernel does not tell",
            "a slow core, where there is one",
        );
    }
    let is = format!("cores {}", lists.join(", "));
    let Some(last) = slow.last().filter(|_| !elsewhere.is_empty()) else {
        return Finding::good(SUBJECT, is);
    };
    Finding::weak(
        SUBJECT,
        format!("{is}: it takes time from the robot's threads, which have the fast ones"),
        "a slow core",
    )
    .with(format!("echo {last} | sudo tee {}", elsewhere.join(" ")))
}

/// Of a list as the kernel writes it: `0-3,6`.
fn cores_of(list: &str) -> Vec<usize> {
    let range = |part: &str| {
        let (first, last) = part.split_once('-').unwrap_or((part, part));
        Some(first.trim().parse().ok()?..=last.trim().parse().ok()?)
    };
    list.split(',').filter_map(range).flatten().collect()
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
        let of = |interface, slow: &[usize]| {
            let found = findings(&fake.computer(), interface, Some(80), slow);
            let told = { found.into_iter() }.map(|own| (own.verdict, own.is, own.command));
            told.collect::<Vec<_>>()
        };
        let first = (Verdict::Good, "24".to_owned(), None);
        // All of its cores are alike.
        let place = |verdict, is: &str, command: Option<&str>| {
            (verdict, is.to_owned(), command.map(str::to_owned))
        };
        let good = place(Verdict::Good, "cores 1", None);
        assert_eq!(of("eth0", &[]), [first.clone(), good.clone()]);
        assert_eq!(of("eth0", &[0, 1]), [first.clone(), good]);
        let weak = place(
            Verdict::Weak,
            "cores 1: it takes time from the robot's threads, which have the fast ones",
            Some("echo 3 | sudo tee /proc/irq/24/smp_affinity_list"),
        );
        assert_eq!(of("eth0", &[2, 3]), [first, weak]);
        assert_eq!(of("eth1", &[])[0].0, Verdict::Unknown);
    }

    #[test]
    fn lists_of_cores_are_read_as_the_kernel_writes_them() {
        assert_eq!(cores_of("0-3,6\n"), [0, 1, 2, 3, 6]);
        assert_eq!(cores_of("5"), [5]);
        assert_eq!(cores_of(""), [0; 0]);
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
            findings(&fake.computer(), "eth0", Some(80), &[0, 1, 2, 3])
        };
        let [first, place] = of(85).try_into().expect("two of them");
        assert_eq!((first.verdict, first.is.as_str()), (Verdict::Good, "71"));
        assert_eq!(
            (place.verdict, place.is.as_str()),
            (Verdict::Good, "cores 0-3")
        );
        let behind = of(50).remove(0);
        assert_eq!(behind.verdict, Verdict::Weak);
        assert_eq!(behind.command.as_deref(), Some("sudo chrt -f -p 85 60"));
    }
}
