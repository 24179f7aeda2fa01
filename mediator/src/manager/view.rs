//! Why a robot waits, in sentences, from all parts of the manager at one time.

use std::fmt;

use super::areas::{Areas, Reservations};
use super::coordinations::Coordinations;
use super::error::UnknownRobot;
use super::names::{Names, RobotName, listed, second_of};
use super::peers::Peers;
use super::sessions::Sessions;
use crate::nets::Kind;

/// All parts of the manager, to look at.
pub(crate) struct View<'a> {
    pub(crate) names: &'a Names,
    pub(crate) peers: &'a Peers,
    pub(crate) sessions: &'a Sessions,
    pub(crate) areas: &'a Areas,
    pub(crate) coordinations: &'a Coordinations,
    pub(crate) now_ns: u64,
}

/// Whom a robot waits for, written only when it is read.
enum Reason<'a> {
    /// A second process of a robot, which is silent.
    SilentSecond { id: &'a str, area: String },
    /// One that is heard.
    Second(&'a str),
    /// A robot that has the area.
    Body {
        id: &'a str,
        how: &'static str,
        fence: Option<u64>,
        silent: bool,
    },
    /// A robot that is let in first.
    Before(&'a RobotName),
}

impl fmt::Display for Reason<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SilentSecond { id, area } => write!(
                f,
                "{} (silent; look, and if no such body is there: `mediator clear {area} --taken-away`)",
                second_of(id)
            ),
            Self::Second(id) => write!(f, "{} (standing there)", second_of(id)),
            Self::Body {
                id,
                how,
                fence,
                silent,
            } => {
                write!(f, "{id} ({how}")?;
                if let Some(fence) = fence {
                    write!(f, ", fence {fence}")?;
                }
                f.write_str(if *silent { ", silent)" } else { ")" })
            }
            Self::Before(RobotName { id, role, .. }) => {
                write!(f, "{id} ({role}, asked before it or goes first)")
            }
        }
    }
}

impl View<'_> {
    /// Why a robot waits, a sentence for each area that it has asked for.
    pub(crate) fn why(&self, robot_id: &str) -> Result<String, UnknownRobot> {
        let Some(robot) = self.names.robot(robot_id) else {
            return Err(UnknownRobot {
                found: robot_id.to_owned(),
                known: self.names.all_robots(),
            });
        };
        let mut lines: Vec<String> = { self.areas.robot(robot).waits() }
            .map(|area| {
                let why = self.explain(robot, area);
                format!(
                    "{robot_id} waits for area {} {why}",
                    self.names.area_id(area)
                )
            })
            .collect();
        if let Some((instance, role)) = self.coordinations.control_of(robot) {
            lines.push(format!(
                "{robot_id} takes part in coordination {} as {}: {}",
                instance.plan.id,
                instance.plan.roles[role].name,
                instance.why(role, |robot| self.names.robot_id(robot))
            ));
        }
        if lines.is_empty() {
            let session = self.sessions.robot(robot);
            // As `status` says it.
            let reports = self.peers.is_heard(robot, self.now_ns);
            lines.push(match (session.number, session.is_heard()) {
                (_, false) if reports => match &session.refused {
                    Some((_, why)) => format!("{robot_id} reports, and is refused: {why}"),
                    None => format!("{robot_id} reports, and does not follow this mediator yet"),
                },
                (0, _) => format!("{robot_id} was never heard of"),
                (_, false) => format!("{robot_id} is silent, and waits for nothing"),
                (_, true) => { self.explain_lease(robot) }
                    .unwrap_or_else(|| format!("{robot_id} waits for nothing")),
            });
        }
        Ok(lines.join("\n"))
    }

    /// Whether the robot may enter what it has: not while another mediator may take that from it, as none can once all robots have
    /// followed this one since it started, or asked all anew. One that has nothing to enter is told all the same that it is heard: else
    /// it takes this mediator for deaf.
    pub(crate) fn may_have_lease(&self, robot: usize) -> bool {
        let leads_all = !self.peers.stands_by && self.sessions.awaited().is_empty();
        leads_all || !self.areas.may_enter(robot)
    }

    /// In a sentence, why a robot that is heard does not enter what it has.
    fn explain_lease(&self, robot: usize) -> Option<String> {
        let why = self.explain_rest()?;
        let id = self.names.robot_id(robot);
        { self.areas.may_enter(robot) }.then(|| format!("{id} enters nothing that it has: {why}"))
    }

    /// In a sentence, why nothing is granted to anybody.
    fn explain_rest(&self) -> Option<String> {
        if self.peers.stands_by {
            let stands_by = "this mediator stands by, since robots follow another one";
            return Some(stands_by.to_owned());
        }
        (!self.sessions.awaited().is_empty()).then(|| self.explain_awaited())
    }

    /// In a sentence, why nothing is granted after a start.
    fn explain_awaited(&self) -> String {
        let awaited = self.sessions.awaited().iter().copied();
        let unknown_for_ns = |robot: usize| {
            let session = self.sessions.robot(robot);
            let heard = session.is_heard() && self.areas.robot(robot).located;
            session.unknown_for_ns(self.now_ns) * u64::from(heard)
        };
        let longest_ns = awaited.clone().map(unknown_for_ns).max().unwrap_or(0);
        let silent = awaited.clone().filter(|&robot| unknown_for_ns(robot) == 0);
        if silent.clone().next().is_some() {
            let robots = self.names.robot_list(silent);
            return format!(
                "nothing is granted until {robots} has reported where it stands, or is said to be absent"
            );
        }
        let robots = self.names.robot_list(awaited);
        format!(
            "nothing is granted for {:.1} s: {robots} may still enter what an earlier mediator granted to a process before",
            longest_ns as f64 * 1e-9
        )
    }

    /// In a sentence, why a robot that has asked for an area was not granted it.
    pub(crate) fn explain(&self, robot: usize, area: usize) -> String {
        let occupant = self.areas.robot(robot);
        let asked_ns = occupant
            .claim(area)
            .map_or(self.now_ns, |claim| claim.asked_ns);
        let since_s = self.now_ns.saturating_sub(asked_ns) as f64 * 1e-9;
        let text = format!("for {since_s:.1} s: ");
        if let Some(why) = self.explain_rest() {
            return text + &why;
        }
        if !self.sessions.is_heard(robot) {
            return text + "the robot itself is silent";
        }
        if !occupant.located {
            return text + "the robot itself does not know where it is";
        }
        if let Some(closed) = &self.areas.area(area).closed
            && !occupant.stands_in(area)
        {
            return text + &format!("it is closed, by {closed}");
        }
        let kept = self.coordinations.kept(area);
        if !kept.contains(&robot) && !occupant.stands_in(area) {
            if let Some(why) = self.explain_net(robot, area) {
                return text + &why;
            }
            let waited_for =
                { kept.iter() }.find(|&&other| !self.areas.robot(other).occupies(area));
            if let Some(&other) = waited_for {
                return text
                    + &format!("a coordination keeps it for {}", self.names.robot_id(other));
            }
        }
        text + &self.explain_others(robot, area)
    }

    /// Robots that have the area, and those of which a second process is in it.
    pub(crate) fn bodies_in(&self, area: usize) -> (Vec<usize>, Vec<usize>) {
        let all = || self.areas.occupants(area);
        let robot = |robot: usize| self.areas.robot(robot);
        let own = all().filter(|&own| robot(own).has(area));
        let seconds = all().filter(|&own| robot(own).seconds.are_in(area));
        (own.collect(), seconds.collect())
    }

    /// Who is in the area, and who comes first.
    fn explain_others(&self, robot: usize, area: usize) -> String {
        let inside = { self.areas.occupants(area) }.flat_map(|other| {
            self.explain_second(other, area).into_iter().chain({
                (other != robot)
                    .then(|| self.explain_body(other, area))
                    .flatten()
            })
        });
        let queue = &self.areas.area(area).queue;
        let before = { queue.iter() }
            .take_while(|&&other| other != robot)
            .map(|&other| Reason::Before(&self.names.robots()[other]));
        match listed(inside.chain(before)) {
            nobody if nobody.is_empty() => "it is about to be granted".to_owned(),
            others => others,
        }
    }

    /// Of a second process of a robot, if it is in the area.
    fn explain_second(&self, robot: usize, area: usize) -> Option<Reason<'_>> {
        let (it, id) = (self.areas.robot(robot), &self.names.robots()[robot].id);
        if it.seconds.are_silent_in(area, self.now_ns) {
            let area = self.names.area_id(area);
            Some(Reason::SilentSecond { id, area })
        } else {
            it.seconds.are_in(area).then_some(Reason::Second(id))
        }
    }

    /// Of a robot, if it has the area.
    fn explain_body(&self, robot: usize, area: usize) -> Option<Reason<'_>> {
        let (it, id) = (self.areas.robot(robot), &self.names.robots()[robot].id);
        if !it.has(area) {
            return None;
        }
        let silent = !self.sessions.is_heard(robot);
        let (how, fence) = match it.claim(area) {
            _ if it.intrudes(area) => ("in it without a grant", None),
            Some(claim) if claim.is_entered() => {
                let is_in = it.stands_in(area) || !it.placed || !it.located;
                let left = "has left it, may come back";
                (if is_in { "in it" } else { left }, Some(claim.fence))
            }
            Some(claim) if claim.is_held() => ("granted", Some(claim.fence)),
            _ => ("standing there", None),
        };
        Some(Reason::Body {
            id,
            how,
            fence,
            silent,
        })
    }

    /// Why no net lets a robot into an area, if nothing else could.
    fn explain_net(&self, robot: usize, area: usize) -> Option<String> {
        let name = |robot: usize| self.names.robot_id(robot);
        if let Some((instance, role)) = self.coordinations.control_of(robot) {
            return Some(format!(
                "coordination {} has its discrete control, and gives it only areas of its orders; {}",
                instance.plan.id,
                instance.why(role, name)
            ));
        }
        let (plan, instance) = self.coordinations.governor(area)?;
        let Some(instance) = instance else {
            let inside = plan.governed.iter().flat_map(|&area| {
                let (own, seconds) = self.bodies_in(area);
                let own = own.into_iter().map(name);
                let all = own.chain(seconds.into_iter().map(|robot| second_of(&name(robot))));
                let id = self.names.area_id(area);
                all.map(move |body| format!("{body} in {id}"))
            });
            return Some(format!(
                "net {} decides, which starts when its areas are empty: {}",
                plan.net,
                listed(inside)
            ));
        };
        let role = instance.role_of(robot);
        let role = role.filter(|&role| matches!(plan.roles[role].kind, Kind::Access(_)));
        Some(match role {
            Some(role) => instance.why(role, name),
            None => format!("net {} decides, in which it has no role", plan.net),
        })
    }
}
