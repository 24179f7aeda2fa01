//! What a message to the mediator must keep before anything is made of it, so that neither log nor work grow with what it contains.

use std::borrow::Cow;

use contract::decode;
use contract::wire::{Control, RobotReport};
use description::names::is_key_part;

/// No name of a site, and no state, is longer than that, bytes.
pub(super) const LONGEST_TEXT: usize = 256;
/// No site has more areas.
const MOST_AREAS: usize = 4096;
/// No net has more flags for one robot, or ways to set them.
const MOST_FLAGS: usize = 256;

/// The report in a message, which must be of the robot that its key names.
///
/// # Errors
/// A sentence, short whatever the message holds.
pub fn report_in(key: &str, message: &[u8]) -> Result<RobotReport, String> {
    let id = part_before_last(key).filter(|id| is_key_part(id) && id.len() <= LONGEST_TEXT);
    let id = id.ok_or_else(|| "a key names no robot".to_owned())?;
    let report =
        decode::<RobotReport>(message).map_err(|_| format!("that of `{id}` is no report"))?;
    if report.robot_id != id {
        return Err(format!("that of `{id}` is of another robot"));
    }
    if !texts(&report).all(is_text) {
        return Err(format!(
            "that of `{id}` has a text of more than {LONGEST_TEXT} bytes, or with control characters"
        ));
    }
    let (access, revocations) = (report.access.len(), report.revocations.len());
    let lists = [
        access,
        revocations,
        report.stands_in.len(),
        report.floor.len(),
    ];
    if lists.into_iter().any(|found| found > MOST_AREAS) {
        return Err(format!("that of `{id}` lists more than {MOST_AREAS} areas"));
    }
    if report.control.as_ref().is_some_and(is_too_long) {
        return Err(format!(
            "that of `{id}` has a control with more than {MOST_FLAGS} flags or paths, or {MOST_AREAS} areas"
        ));
    }
    Ok(report)
}

/// A robot need say no more of its control than coordination and level; one that repeats all is understood as well.
fn is_too_long(control: &Control) -> bool {
    let paths = control.paths.iter().map(|path| path.flags.len());
    let lists = [control.flags.len(), control.paths.len()];
    let orders = control
        .flags
        .iter()
        .filter_map(|flag| flag.instruction.as_ref());
    let areas: usize = orders.map(|order| order.areas.len()).sum();
    lists
        .into_iter()
        .chain(paths)
        .any(|found| found > MOST_FLAGS)
        || areas > MOST_AREAS
}

/// Of whom a key is.
pub(super) fn part_before_last(key: &str) -> Option<&str> {
    key.rsplit('/').nth(1)
}

/// Of a length, and with characters, that logs and terminals of others can take.
pub(super) fn is_text(text: &str) -> bool {
    text.len() <= LONGEST_TEXT && !text.chars().any(char::is_control)
}

/// What somebody has written, as logs, the journal and terminals of others can take it: of what is no text only the beginning, its
/// control characters told by their numbers.
pub(super) fn shown(text: &str) -> Cow<'_, str> {
    const BEGINNING: usize = 60;
    if is_text(text) {
        return Cow::Borrowed(text);
    }
    let beginning = text.chars().take(BEGINNING).flat_map(char::escape_debug);
    Cow::Owned(format!("\"{}…\"", beginning.collect::<String>()))
}

/// All that people may be told of, or the journal keeps; of a factsheet it keeps as much as it wants.
fn texts(report: &RobotReport) -> impl Iterator<Item = &str> {
    { [report.site.as_str(), report.fsm_state.as_str()].into_iter() }
        .chain(report.stands_in.iter().map(String::as_str))
        .chain(report.access.iter().map(|own| own.area.as_str()))
        .chain(report.revocations.iter().map(|own| own.area.as_str()))
        .chain(report.floor.iter().map(|own| own.id.as_str()))
        .chain(report.control.iter().flat_map(texts_of_control))
}

fn texts_of_control(control: &Control) -> impl Iterator<Item = &str> {
    let orders = control
        .flags
        .iter()
        .filter_map(|flag| flag.instruction.as_ref());
    { [control.net.as_str()].into_iter() }
        .chain(
            control
                .flags
                .iter()
                .flat_map(|flag| [flag.name.as_str(), &flag.on_output]),
        )
        .chain(orders.clone().map(|order| order.event.as_str()))
        .chain(orders.flat_map(|order| order.areas.iter().map(String::as_str)))
}

#[cfg(test)]
mod tests {
    use contract::Message;
    use contract::wire::{Access, ControlFlag, ControlPath, FloorArea, Instruction};

    use super::*;

    fn report() -> RobotReport {
        RobotReport {
            robot_id: "amr-1".into(),
            site: "hall".into(),
            ..RobotReport::default()
        }
    }

    fn refusal(report: &RobotReport) -> Option<String> {
        report_in("fleet/robots/amr-1/report", &report.encode_to_vec()).err()
    }

    #[test]
    fn whose_it_is_says_the_key() {
        assert_eq!(refusal(&report()), None);
        let long = "x".repeat(LONGEST_TEXT + 1);
        for id in ["a b", "", "a\nb", long.as_str()] {
            let other = RobotReport {
                robot_id: id.into(),
                ..report()
            };
            let why = refusal(&other).expect("of another robot");
            assert!(why.len() < 100, "{why}");
            let key = format!("fleet/robots/{id}/report");
            let why = report_in(&key, &other.encode_to_vec()).expect_err("no name");
            assert_eq!(why, "a key names no robot");
        }
    }

    #[test]
    fn texts_are_short_and_of_one_line() {
        let ways: [fn(&mut RobotReport, String); 11] = [
            |own, net| {
                own.control = Some(Control {
                    net,
                    ..Control::default()
                });
            },
            |own, name| {
                own.control = with_flag(ControlFlag {
                    name,
                    ..ControlFlag::default()
                });
            },
            |own, on_output| {
                own.control = with_flag(ControlFlag {
                    on_output,
                    ..ControlFlag::default()
                });
            },
            |own, event| {
                own.control = with_order(Instruction {
                    event,
                    ..Instruction::default()
                });
            },
            |own, area| {
                own.control = with_order(Instruction {
                    areas: vec![area],
                    ..Instruction::default()
                });
            },
            |own, text| own.site = text,
            |own, text| own.fsm_state = text,
            |own, text| own.stands_in.push(text),
            |own, area| {
                own.access.push(Access {
                    area,
                    ..Access::default()
                })
            },
            |own, area| {
                own.revocations.push(Access {
                    area,
                    ..Access::default()
                })
            },
            |own, id| {
                own.floor.push(FloorArea {
                    id,
                    ..FloorArea::default()
                })
            },
        ];
        for (number, way) in ways.into_iter().enumerate() {
            for (text, is_good) in [
                ("x".repeat(LONGEST_TEXT), true),
                ("x".repeat(LONGEST_TEXT + 1), false),
                ("x\ny".to_owned(), false),
                ("\u{1b}[2J".to_owned(), false),
            ] {
                let mut report = report();
                way(&mut report, text);
                assert_eq!(refusal(&report).is_none(), is_good, "{number}");
            }
        }
    }

    fn with_flag(flag: ControlFlag) -> Option<Control> {
        Some(Control {
            flags: vec![flag],
            ..Control::default()
        })
    }

    fn with_order(order: Instruction) -> Option<Control> {
        with_flag(ControlFlag {
            instruction: Some(order),
            ..ControlFlag::default()
        })
    }

    #[test]
    fn so_is_what_a_robot_says_of_its_control() {
        let flags = |count| Control {
            flags: vec![ControlFlag::default(); count],
            ..Control::default()
        };
        let paths = |count| Control {
            paths: vec![ControlPath::default(); count],
            ..Control::default()
        };
        let path = |count| Control {
            paths: vec![ControlPath {
                flags: vec![0; count],
            }],
            ..Control::default()
        };
        let ways: [&dyn Fn(usize) -> Control; 3] = [&flags, &paths, &path];
        for (number, way) in ways.into_iter().enumerate() {
            for (count, is_good) in [(MOST_FLAGS, true), (MOST_FLAGS + 1, false)] {
                let report = RobotReport {
                    control: Some(way(count)),
                    ..report()
                };
                assert_eq!(refusal(&report).is_none(), is_good, "{number}: {count}");
            }
        }
        let areas = vec!["1".to_owned(); MOST_AREAS + 1];
        let many = RobotReport {
            control: with_order(Instruction {
                areas,
                ..Instruction::default()
            }),
            ..report()
        };
        assert!(refusal(&many).is_some());
    }

    #[test]
    fn lists_are_as_long_as_a_site_can_need() {
        let mut report = report();
        report.stands_in = vec!["x".into(); MOST_AREAS];
        assert_eq!(refusal(&report), None);
        report.stands_in.push("x".into());
        assert!(refusal(&report).is_some());
    }
}
