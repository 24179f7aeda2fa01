//! `mediator status`, `why`, `clear`, `end`, `absent` and `orders`: what a running mediator answers.

use std::io::Write;

use super::failure::Failure;
use super::which::Which;
use crate::manager::{AreaStatus, CoordinationStatus, RobotStatus, Status, second_of};
use crate::runtime::{Answer, Question};

pub(super) fn status(which: &Which, json: bool) -> Result<(), Failure> {
    let status = match which.ask(&Question::Status)? {
        Answer::Status(status) => status,
        answer => return Err(unexpected(answer)),
    };
    let text = if json {
        serde_json::to_string_pretty(&status).expect("a status is always JSON") + "\n"
    } else {
        describe(&status)
    };
    // A reader that closes the pipe early is no failure.
    let _ = std::io::stdout().write_all(text.as_bytes());
    Ok(())
}

pub(super) fn order(which: &Which, question: &Question) -> Result<(), Failure> {
    match which.ask(question)? {
        Answer::Done(text) => {
            // A reader that closes the pipe early is no failure.
            let _ = writeln!(std::io::stdout(), "{text}");
            Ok(())
        }
        answer => Err(unexpected(answer)),
    }
}

pub(super) fn orders(which: &Which) -> Result<(), Failure> {
    let orders = match which.ask(&Question::Orders)? {
        Answer::Orders(orders) => orders,
        answer => return Err(unexpected(answer)),
    };
    let mut out = std::io::stdout().lock();
    for order in orders {
        let done = if order.done { "done" } else { "refused" };
        // A reader that closes the pipe early is no failure.
        let _ = writeln!(
            out,
            "{}",
            on_one_line(&format!(
                "{} {}: {}: {done}: {}",
                order.at, order.who, order.order, order.answer
            ))
        );
    }
    Ok(())
}

/// Journals of older mediators hold what was ordered as it was sent.
fn on_one_line(text: &str) -> String {
    let escaped = |c: char| {
        let escaped = c.is_control().then(|| c.escape_default());
        let own = (!c.is_control()).then_some(c);
        escaped.into_iter().flatten().chain(own)
    };
    text.chars().flat_map(escaped).collect()
}

fn unexpected(answer: Answer) -> Failure {
    match answer {
        Answer::Refused(why) => Failure::Refused(format!("refused: {why}")),
        Answer::Underway(what) => Failure::Failed(what),
        answer => Failure::Failed(format!("unexpected answer: {answer:?}")),
    }
}

fn describe(status: &Status) -> String {
    let mut text = format!("start {} of this mediator\n", status.epoch);
    if status.stands_by {
        text += "robots follow another mediator: this one stands by and grants nothing; end the wrong one\n";
    }
    if !status.awaited.is_empty() {
        text += &format!(
            "nothing is granted until these have reported where they stand, or an operator says `mediator absent`: {}\n",
            status.awaited.join(", ")
        );
    }
    text += "\nareas\n";
    status
        .areas
        .iter()
        .for_each(|area| text += &describe_area(area));
    text += "\nrobots\n";
    status
        .robots
        .iter()
        .for_each(|robot| text += &describe_robot(robot));
    for coordination in &status.coordinations {
        text += &describe_coordination(coordination);
    }
    text
}

fn describe_coordination(own: &CoordinationStatus) -> String {
    let robots: Vec<String> = { own.robots.iter() }
        .map(|(role, robot)| format!("{robot} as {role}"))
        .collect();
    let mut text = format!("\ncoordination {} {}", own.id, own.number);
    text += match (own.over, own.situation.is_empty()) {
        (true, _) => ", over",
        (false, true) => ", robots are told to get out of the way",
        (false, false) => "",
    };
    text += &format!(": {}\n", robots.join(", "));
    if !own.over {
        text += &format!("  marked: {}\n", own.marking.join(", "));
        for ((_, robot), why) in own.robots.iter().zip(&own.waits) {
            text += &format!("  {robot}: {why}\n");
        }
    }
    text
}

fn describe_area(area: &AreaStatus) -> String {
    let mut parts = Vec::new();
    for (robot, fence) in &area.holders {
        parts.push(format!("{robot} (fence {fence})"));
    }
    for robot in &area.standing {
        parts.push(format!("{robot} (without a grant)"));
    }
    parts.extend(area.seconds.iter().map(|robot| second_of(robot)));
    if parts.is_empty() {
        parts.push("free".to_owned());
    }
    let mut line = format!("  {:<12} {}", area.id, parts.join(", "));
    if area.capacity > 1 {
        line += &format!("; holds {}", area.capacity);
    }
    if !area.waiting.is_empty() {
        line += &format!("; waiting: {}", area.waiting.join(", "));
    }
    if area.blocked {
        line += "; blocked by one that is silent";
    }
    match &area.closed_by {
        Some(closed) => line += &format!("; closed by {closed}"),
        None if area.closed => line += "; closed, since too many are in it, or one without a grant",
        None => {}
    }
    line + "\n"
}

/// Which protocols a robot says that it knows, after its speed.
fn known_protocols(protocols: &[u32]) -> String {
    let numbers: Vec<String> = protocols.iter().map(u32::to_string).collect();
    match &numbers[..] {
        [] => String::new(),
        [one] => format!(", protocol {one}"),
        all => format!(", protocols {}", all.join(" and ")),
    }
}

fn describe_robot(robot: &RobotStatus) -> String {
    let heard = match (robot.session, robot.heard) {
        _ if robot.reports && !robot.heard => {
            "reports, and does not follow this mediator yet".to_owned()
        }
        (0, _) => "never heard of".to_owned(),
        (_, true) => format!("heard {} ms ago", robot.age_ms),
        (_, false) => "silent".to_owned(),
    };
    let located = if robot.heard && !robot.located {
        ", not located"
    } else {
        ""
    };
    let mut text = format!("  {:<12} {}, {heard}{located}\n", robot.id, robot.role);
    if let Some(own) = &robot.factsheet {
        text += &format!(
            "    {} {}, {}, at most {} m/s{}\n",
            own.manufacturer,
            own.model,
            own.software,
            own.max_speed_m_s,
            known_protocols(&own.protocols)
        );
    }
    for (area, why) in &robot.waits {
        text += &format!("    waits for {area} {why}\n");
    }
    if robot.is_doubled {
        text += "    a second process reports as this robot, and is refused: end one of them\n";
    }
    if !robot.second_in.is_empty() {
        text += &format!(
            "    a second process stands in {}, or did, as one before may have, when it fell silent: look, and if no such body is there, `mediator clear AREA --taken-away`\n",
            robot.second_in.join(", ")
        );
    }
    if robot.doubled > 0 {
        text += &format!("    found {} times: a second process\n", robot.doubled);
    }
    if !robot.refusal.is_empty() {
        text += &format!("    refused: {}\n", robot.refusal);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_order_is_one_line_whatever_was_ordered() {
        let text = on_one_line("clear x\n2026 bob: absent \u{1b}[2J\u{9b}0m 🚧");
        assert_eq!(text, "clear x\\n2026 bob: absent \\u{1b}[2J\\u{9b}0m 🚧");
    }
}
