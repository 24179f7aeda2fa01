//! Who is in which area by truth, against the grants that an independent listener heard.

use contract::timing::{ENTERS_WITHIN_NS, LEASE_NS};
use description::geometry::Rect;
use sim::world::{Pose, Rectangle, Truth};

use super::conduct::Conduct;
use super::look::{Look, Robot, is_carried, place};
use super::violations::Violations;
use crate::scenario::{Scenario, ScriptedFault, ScriptedKind};
use crate::shapes::touch;
use crate::violation::ViolationKind;

/// A footprint may reach this far over a border: about the error of a robot's pose.
const REACH_IN_M: f64 = 0.02;
/// The listener hears a message at most this much before or after its addressee.
const HEARING_NS: u64 = 100_000_000;
/// From what a robot hears until it brakes.
const OBEYS_S: f64 = 0.3;
/// Places at which it is looked whether a robot on its way to a stop is in an area.
const STEPS: u32 = 20;

/// Watches the areas of a site.
#[derive(Debug)]
pub(super) struct Areas {
    areas: Vec<Area>,
    /// Whether grants are heard at all.
    heard: bool,
    /// From when on, since the start, the mediator may have forgotten what it has granted.
    forgets_s: f64,
    /// By the robots' numbers: from when on, since the start, another robot may have its identity, and give back what it has.
    doubled_s: Vec<f64>,
    start_ns: u64,
}

#[derive(Debug)]
struct Area {
    id: String,
    capacity: usize,
    /// Its region, less what a footprint may reach in.
    inner: Rectangle,
    /// By the robots' numbers.
    presence: Vec<Presence>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Presence {
    inside: bool,
    /// It has stood there since before anybody could have granted it.
    excused: bool,
    /// An operator said that it is not there any more.
    cleared: bool,
    /// It had a grant since it came in.
    granted: bool,
    /// Since when it has been inside without a grant.
    without_ns: Option<u64>,
    /// When it came in while a net had control of it, until that is judged.
    entered_ns: Option<u64>,
    /// When it came in; none: it stood there when it was first looked at.
    came_ns: Option<u64>,
    /// The coordination that has the robot's discrete control, once that was judged: until when the robot may come in if it could not stop
    /// before the area then.
    control: Option<(u64, Option<u64>)>,
    /// Of a second robot with one identity: since when the mediator may know of it; none: it does not.
    known_ns: Option<u64>,
}

impl Presence {
    /// Whether a second robot with one identity counts where the last one came in then. Nobody knows of it before it has said where
    /// it stands, and what was granted before is entered as long as the lease lasts.
    fn was_known(&self, last_ns: Option<u64>) -> bool {
        let known_ns = { self.known_ns }.map(|ns| ns + LEASE_NS + ENTERS_WITHIN_NS + HEARING_NS);
        self.came_ns.is_some() || known_ns.is_some() && known_ns < last_ns
    }
}

impl Areas {
    /// Those of a scenario with so many bodies, clones included; grants are judged where they are `heard`.
    pub(super) fn new(scenario: &Scenario, bodies: usize, heard: bool, start_ns: u64) -> Self {
        let forgets = |fault: &&ScriptedFault| {
            // Of two, the one that stands by knows nothing of what the other one has granted.
            let kinds = [
                ScriptedKind::LoseJournal,
                ScriptedKind::RestoreJournal,
                ScriptedKind::SecondMediator,
                ScriptedKind::CopiedMediator,
            ];
            kinds.contains(&fault.what)
        };
        let forgets_s = { scenario.faults.iter() }
            .filter(forgets)
            .map(|fault| fault.at_s);
        let doubled_s = |body: usize| {
            let clones = scenario.clones().enumerate();
            let own = clones
                .filter(|&(number, (_, of))| body == of || body == scenario.robots.len() + number);
            own.map(|(_, (fault, _))| scenario.faults[fault].at_s)
                .fold(f64::INFINITY, f64::min)
        };
        let areas = { scenario.site.areas.iter() }
            .map(|area| Area {
                id: area.id.clone(),
                capacity: area.capacity as usize,
                inner: shrunk(&area.region, REACH_IN_M),
                presence: vec![Presence::default(); bodies],
            })
            .collect();
        Self {
            areas,
            heard,
            forgets_s: forgets_s.fold(f64::INFINITY, f64::min),
            doubled_s: (0..bodies).map(doubled_s).collect(),
            start_ns,
        }
    }

    /// An operator said that this robot is not in the area, whatever the truth is.
    pub(super) fn cleared(&mut self, area: &str, robot: usize) {
        if let Some(area) = self.areas.iter_mut().find(|own| own.id == area) {
            area.presence[robot].cleared = true;
        }
    }

    /// Areas into which the robot's footprint reaches, by truth.
    pub(super) fn inside(&self, robot: usize) -> Vec<&str> {
        { self.areas.iter() }
            .filter(|area| area.presence.get(robot).is_some_and(|own| own.inside))
            .map(|area| area.id.as_str())
            .collect()
    }

    /// Takes in one look at a robot; `before` is the truth at the look before, if there was one.
    pub(super) fn judge(
        &mut self,
        robots: &[Conduct],
        look: &Look<'_>,
        before: Option<Truth>,
        violations: &mut Violations,
    ) {
        let (robot, truth) = (&robots[look.robot].robot, look.truth);
        let body = robot.footprint.at(&truth.pose);
        // It stands there since the start, or somebody has carried it there.
        let is_put = before.is_none_or(|was| is_carried(&was, truth));
        let at_s = truth.time_ns.saturating_sub(self.start_ns) as f64 / 1e9;
        let control = look.observations.control_of(&robot.id, truth.time_ns);
        let given = control.and_then(|own| own.acquired_ns.map(|_| own.number));
        for area in &mut self.areas {
            let had = |at_ns| { look.observations }.had(&robot.id, &area.id, at_ns, HEARING_NS);
            let presence = &mut area.presence[look.robot];
            if given != presence.control.map(|(number, _)| number) {
                let drives_in = |number| (number, drives_in(robot, truth, &area.inner));
                presence.control = given.map(drives_in);
            }
            let was_inside = std::mem::replace(&mut presence.inside, touch(&body, &area.inner));
            presence.excused &= presence.inside;
            presence.cleared &= presence.inside;
            presence.excused |= is_put && presence.inside;
            if presence.inside && !was_inside && !is_put {
                presence.entered_ns = Some(truth.time_ns);
                presence.came_ns = Some(truth.time_ns);
                if let Some(detail) = without_lease(&robot.id, &area.id, look) {
                    violations.report(ViolationKind::Lease, &robot.name, truth.time_ns, detail);
                }
            }
            if let Some(entered_ns) = presence.entered_ns
                && truth.time_ns >= entered_ns + HEARING_NS
            {
                presence.entered_ns = None;
                let until_ns = presence.control.and_then(|(_, until_ns)| until_ns);
                if until_ns.is_none_or(|until_ns| entered_ns > until_ns)
                    && let Some(detail) = uncommanded(&robot.id, &area.id, entered_ns, look)
                {
                    let kind = ViolationKind::UncommandedEntry;
                    violations.report(kind, &robot.name, entered_ns, detail);
                }
                // A grant of an identity, or of a mediator that knows nothing of it any more, need not have been heard.
                let hears = self.heard && !robot.is_clone && at_s < self.forgets_s;
                if hears
                    && !(look.observations).was_given(&robot.id, &area.id, entered_ns, HEARING_NS)
                {
                    let detail = format!(
                        "entered area {}, and says that it was granted, which no mediator had told it",
                        area.id
                    );
                    let kind = ViolationKind::EntryWithoutGrant;
                    violations.report(kind, &robot.name, entered_ns, detail);
                }
            }
            if !presence.inside {
                presence.without_ns = None;
                presence.came_ns = None;
                presence.known_ns = None;
                presence.granted = false;
                continue;
            }
            if robot.is_clone && presence.known_ns.is_none() {
                presence.known_ns = { look.observations }.stands_since_ns(&robot.id, &area.id);
            }
            if !self.heard {
                continue;
            }
            if had(truth.time_ns) {
                // Grants are an identity's: a clone that was put there need not have got any.
                presence.excused &= robot.is_clone;
                presence.granted = true;
                presence.without_ns = None;
                continue;
            }
            // What it came in by may be lost with the mediator's journal, also where a process is gone that would have told of it.
            let lost = presence.granted && at_s >= self.forgets_s;
            // A process of another body that speaks for its identity gives back what it came in by, and knows nothing of it.
            let given_back = presence.granted && at_s >= self.doubled_s[look.robot];
            if presence.excused || presence.cleared || lost || given_back {
                continue;
            }
            let since_ns = *presence.without_ns.get_or_insert(truth.time_ns);
            if truth.time_ns - since_ns > HEARING_NS && !had(since_ns) {
                let detail = format!(
                    "in area {} by more than {REACH_IN_M} m, {}, and it has no grant",
                    area.id,
                    place(&truth.pose)
                );
                violations.report(
                    ViolationKind::EntryWithoutGrant,
                    &robot.name,
                    since_ns,
                    detail,
                );
            }
        }
        for area in &self.areas {
            if !area.presence[look.robot].inside {
                continue;
            }
            let last_ns = { area.presence.iter() }.filter_map(|own| own.came_ns).max();
            let inside: Vec<&str> = { robots.iter().zip(&area.presence) }
                .filter(|(_, presence)| presence.inside)
                .filter(|(other, own)| !other.robot.is_clone || own.was_known(last_ns))
                .map(|(other, _)| other.robot.name.as_str())
                .collect();
            if inside.len() > area.capacity {
                let detail = format!(
                    "{} are in area {}, which holds {}",
                    inside.join(", "),
                    area.id,
                    area.capacity
                );
                violations.report(
                    ViolationKind::OverCapacity,
                    &robot.name,
                    truth.time_ns,
                    detail,
                );
            }
        }
    }
}

/// What is wrong with an entry now: the robot heard the mediator so long ago that another one may have been let in.
fn without_lease(robot: &str, area: &str, look: &Look<'_>) -> Option<String> {
    let began_ns = look.observations.lease_began_ns(robot)?;
    let age_ns = look.truth.time_ns.saturating_sub(began_ns);
    (age_ns > LEASE_NS + ENTERS_WITHIN_NS + HEARING_NS).then(|| {
        format!(
            "entered area {area} {:.2} s after it sent the last report that the mediator answered",
            age_ns as f64 / 1e9
        )
    })
}

/// What is wrong with an entry at this time: the net in control of the robot has not ordered it into the area.
fn uncommanded(robot: &str, area: &str, entered_ns: u64, look: &Look<'_>) -> Option<String> {
    let control = look.observations.control_of(robot, entered_ns)?;
    // What it is told and what it says are heard a little apart.
    let acquired_ns = control.acquired_ns?.saturating_add(HEARING_NS);
    let named = control.areas.iter().any(|named| named == area);
    (acquired_ns <= entered_ns && !named).then(|| {
        format!(
            "entered area {area} in coordination {} ({}), which has not ordered it there",
            control.number, control.net
        )
    })
}

/// Until when the robot comes into the area, on the curve that it drives, if it is not in it and does so before it can stop.
fn drives_in(robot: &Robot, truth: &Truth, area: &Rectangle) -> Option<u64> {
    let (pose, twist) = (truth.pose, truth.twist);
    let speed_m_s = twist.v_m_s.abs();
    let braking_s = speed_m_s / robot.deceleration_m_s2;
    let touches = |step: u32| {
        // As far as at this speed in so long a time.
        let after_s = (OBEYS_S + braking_s / 2.0) * f64::from(step) / f64::from(STEPS);
        let turned_rad = twist.omega_rad_s * after_s;
        let along_rad = pose.theta_rad + turned_rad / 2.0;
        let way_m = twist.v_m_s * after_s;
        let there = Pose::new(
            pose.x_m + way_m * along_rad.cos(),
            pose.y_m + way_m * along_rad.sin(),
            pose.theta_rad + turned_rad,
        );
        touch(&robot.footprint.at(&there), area)
    };
    let comes = !touches(0) && (1..=STEPS).any(touches);
    let until_ns = || truth.time_ns + ((OBEYS_S + braking_s) * 1e9) as u64 + HEARING_NS;
    comes.then(until_ns)
}

fn shrunk(region: &Rect, by_m: f64) -> Rectangle {
    let size =
        |axis: usize| (region.max.xy_m()[axis] - region.min.xy_m()[axis] - 2.0 * by_m).max(0.0);
    let [x_m, y_m] = region.centre().xy_m();
    Rectangle::centred(&Pose::new(x_m, y_m, 0.0), size(0), size(1))
}
