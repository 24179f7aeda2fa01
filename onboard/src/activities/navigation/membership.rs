//! Navigation on a managed site: which areas it may use, and what the mediator orders.

use coordination::symbols::{Reader, Stamped, Writer};
use description::geometry::MotionCommand;
use skills::borders::AreaSet;
use skills::navigator::{InstructionError, NavigationOutput};

use super::{Asked, Navigation};
use crate::activities::fleet_link::{Event, NavigationEnd, Order};
use crate::activities::port::Instructed;
use crate::fleet::Answer;
use crate::realtime::clock::SECOND_NS;
use crate::symbols::faults::Fault;
use crate::symbols::values::{AllowedAreas, Whereabouts};

/// Leave that communication has not repeated for longer is none.
const LEAVE_AGE_NS: u64 = SECOND_NS;

/// The symbols that only a managed site needs.
#[derive(Debug)]
pub struct Symbols {
    /// Where the robot may be.
    pub allowed: Reader<AllowedAreas>,
    /// Where it is, in numbers.
    pub whereabouts: Writer<Whereabouts>,
}

/// What navigation keeps of its fleet.
pub(super) struct Membership {
    /// None where nobody manages the areas.
    managed: Option<Managed>,
    allowed: AreaSet,
    speed_limit_m_s: f64,
    relocated: bool,
}

struct Managed {
    symbols: Symbols,
    link: NavigationEnd,
}

/// Nobody manages the areas: everything is allowed.
impl Default for Membership {
    fn default() -> Self {
        Self {
            managed: None,
            allowed: AreaSet::ALL,
            speed_limit_m_s: f64::INFINITY,
            relocated: false,
        }
    }
}

impl Membership {
    pub(super) fn managed(symbols: Symbols, link: NavigationEnd) -> Self {
        Self {
            managed: Some(Managed { symbols, link }),
            allowed: AreaSet::EMPTY,
            ..Self::default()
        }
    }

    /// Areas that the robot may be in.
    pub(super) fn allowed(&self) -> AreaSet {
        self.allowed
    }

    pub(super) fn read(&mut self, now_ns: u64) {
        if let Some(Managed { symbols, .. }) = &mut self.managed {
            self.allowed = leave(&symbols.allowed.read(), now_ns);
        }
    }

    fn next_order(&mut self) -> Option<Order> {
        self.managed.as_mut()?.link.orders.receive()
    }

    /// The command within what the mediator limits.
    pub(super) fn limited(&self, command: MotionCommand) -> MotionCommand {
        let limit_m_s = self.speed_limit_m_s;
        command.with_speed(command.speed_m_s.clamp(-limit_m_s, limit_m_s))
    }
}

/// What communication allows, as long as it says so.
fn leave(allowed: &Stamped<AllowedAreas>, now_ns: u64) -> AreaSet {
    match allowed.age_ns(now_ns) {
        Some(age_ns) if age_ns <= LEAVE_AGE_NS => allowed.value.set(),
        _ => AreaSet::EMPTY,
    }
}

impl Navigation {
    /// Carries out what the mediator has ordered.
    pub(super) fn obey(&mut self) {
        while let Some(order) = self.membership.next_order() {
            match order {
                Order::Instruct(_) if self.asked.is_some() => {
                    // The step to come answers another.
                    self.tell_fleet(Event::Answer(Answer::NotNow));
                }
                Order::Instruct(instruction) => match self.instruct(instruction) {
                    Ok(()) => self.asked = Some(Asked::ByFleet),
                    Err(Instructed::Refused(error)) if error != InstructionError::Full => {
                        self.tell_fleet(Event::Answer(Answer::Refused));
                    }
                    Err(_) => self.tell_fleet(Event::Answer(Answer::NotNow)),
                },
                Order::LimitSpeed(limit_m_s) => {
                    let limit_m_s = limit_m_s.filter(|limit_m_s| !limit_m_s.is_nan());
                    self.membership.speed_limit_m_s = limit_m_s.unwrap_or(f64::INFINITY).max(0.0);
                }
                Order::Relocate {
                    pose,
                    std_m,
                    std_rad,
                    state,
                } => {
                    let start = self.part.start;
                    let (std_m, std_rad) = (std_m.max(start.std_m), std_rad.max(start.std_rad));
                    let navigator = &mut self.part.navigator;
                    self.membership.relocated =
                        navigator.relocate(pose, std_m, std_rad) && navigator.restart_in(state);
                }
            }
        }
    }

    /// The machine has fired these.
    pub(super) fn tell_outputs(&mut self, output: &NavigationOutput) {
        for &event in output.outputs.as_slice() {
            self.tell_fleet(Event::Output(event));
        }
    }

    pub(super) fn tell_fleet(&mut self, event: Event) {
        let Some(Managed { link, .. }) = &mut self.membership.managed else {
            return;
        };
        if link.events.send(event).is_err() {
            let refused = link.events.refused();
            self.port.note(Fault::QueueFull, refused as f64);
        }
    }

    /// Publishes where the robot is after a step, and wakes communication.
    pub(super) fn publish_whereabouts(&mut self, now_ns: u64) {
        // What is old must not look new.
        let stepped = self.output.filter(|output| output.now_ns == now_ns);
        let (Some(output), Some(managed)) = (stepped, &mut self.membership.managed) else {
            return;
        };
        let whereabouts = whereabouts(&output);
        managed.symbols.whereabouts.write(now_ns, &whereabouts);
        if std::mem::take(&mut self.membership.relocated) {
            self.tell_fleet(Event::Relocated);
        }
        if let Some(Managed { link, .. }) = &self.membership.managed {
            link.wake.wake();
        }
    }
}

fn whereabouts(output: &NavigationOutput) -> Whereabouts {
    let covariance = &output.covariance;
    Whereabouts {
        x_m: output.pose.x_m,
        y_m: output.pose.y_m,
        theta_rad: output.pose.theta_rad,
        xx: covariance[0][0],
        xy: covariance[0][1],
        yy: covariance[1][1],
        xt: covariance[0][2],
        yt: covariance[1][2],
        tt: covariance[2][2],
        uncertain: u64::from(output.pose_uncertain),
        state: u64::from(output.state.0),
        waiting_for: output.waiting_for.map_or(u64::MAX, |area| area as u64),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leave_is_only_good_while_it_is_repeated() {
        let set: AreaSet = [1, 2].into_iter().collect();
        let said = |stamp_ns| Stamped {
            stamp_ns,
            value: AllowedAreas::new(&set),
        };
        assert_eq!(leave(&said(5), 5 + LEAVE_AGE_NS), set);
        assert_eq!(leave(&said(5), 6 + LEAVE_AGE_NS), AreaSet::EMPTY);
        assert_eq!(leave(&said(0), 1), AreaSet::EMPTY, "never written");
    }
}
