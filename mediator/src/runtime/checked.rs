//! What a message to the mediator must keep before anything is made of it, so that neither log nor work grow with what it contains.

use contract::decode;
use contract::wire::RobotReport;
use description::names::is_key_part;

/// No name of a site, and no state, is longer than that, bytes.
pub(super) const LONGEST_TEXT: usize = 256;
/// No site has more areas.
const MOST_AREAS: usize = 4096;

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
    Ok(report)
}

/// Of whom a key is.
pub(super) fn part_before_last(key: &str) -> Option<&str> {
    key.rsplit('/').nth(1)
}

/// Of a length, and with characters, that logs and terminals of others can take.
pub(super) fn is_text(text: &str) -> bool {
    text.len() <= LONGEST_TEXT && !text.chars().any(char::is_control)
}

/// All that people may be told of, or the journal keeps; of a factsheet it keeps as much as it wants.
fn texts(report: &RobotReport) -> impl Iterator<Item = &str> {
    { [report.site.as_str(), report.fsm_state.as_str()].into_iter() }
        .chain(report.stands_in.iter().map(String::as_str))
        .chain(report.access.iter().map(|own| own.area.as_str()))
        .chain(report.revocations.iter().map(|own| own.area.as_str()))
        .chain(report.floor.iter().map(|own| own.id.as_str()))
}

#[cfg(test)]
mod tests {
    use contract::Message;
    use contract::wire::{Access, FloorArea};

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
        let ways: [fn(&mut RobotReport, String); 6] = [
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

    #[test]
    fn lists_are_as_long_as_a_site_can_need() {
        let mut report = report();
        report.stands_in = vec!["x".into(); MOST_AREAS];
        assert_eq!(refusal(&report), None);
        report.stands_in.push("x".into());
        assert!(refusal(&report).is_some());
    }
}
