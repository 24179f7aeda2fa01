//! Navigation on a managed site: which areas it may use, and what the mediator orders.

use coordination::symbols::Stamped;
use description::geometry::MotionCommand;
use skills::borders::AreaSet;

use crate::activities::fleet_link::{NavigationEnd, NavigationEvent};
use crate::activities::port::Port;
use crate::fleet::{Directive, LEAVE_AGE_NS};
use crate::symbols::faults::Fault;
use crate::symbols::wiring::NavigationFleetSymbols;

/// What navigation keeps of its fleet.
pub(super) struct Membership {
    /// `None` where nobody manages the areas.
    managed: Option<Managed>,
    allowed: AreaSet,
    speed_limit_m_s: f64,
    relocated: bool,
}

struct Managed {
    symbols: NavigationFleetSymbols,
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
    pub(super) fn managed(symbols: NavigationFleetSymbols, link: NavigationEnd) -> Self {
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

    /// The next thing that the mediator has ordered.
    pub(super) fn next_order(&mut self) -> Option<Directive> {
        self.managed.as_mut()?.link.orders.receive()
    }

    /// Drive no faster than this from now on.
    pub(super) fn limit_speed(&mut self, limit_m_s: Option<f64>) {
        let limit_m_s = limit_m_s.filter(|limit_m_s| !limit_m_s.is_nan());
        self.speed_limit_m_s = limit_m_s.unwrap_or(f64::INFINITY).max(0.0);
    }

    /// The robot was put somewhere else: communication is told after the whereabouts say so.
    pub(super) fn relocated(&mut self) {
        self.relocated = true;
    }

    /// Tells communication what happened.
    pub(super) fn tell(&mut self, event: NavigationEvent, port: &mut Port) {
        let Some(Managed { link, .. }) = &mut self.managed else {
            return;
        };
        if link.events.send(event).is_err() {
            port.note(Fault::QueueFull, link.events.refused() as f64);
        }
    }

    /// The whereabouts after a step are published: wakes communication.
    pub(super) fn published(&mut self, now_ns: u64, port: &mut Port) {
        if std::mem::take(&mut self.relocated) {
            self.tell(NavigationEvent::Relocated, port);
        }
        if let Some(Managed { link, .. }) = &self.managed {
            link.wake.wake(now_ns);
        }
    }

    /// The command, within the mediator's speed limit.
    pub(super) fn limited(&self, command: MotionCommand) -> MotionCommand {
        let limit_m_s = self.speed_limit_m_s;
        command.with_speed(command.speed_m_s.clamp(-limit_m_s, limit_m_s))
    }
}

/// What communication allows, while it repeats that.
fn leave(allowed: &Stamped<AreaSet>, now_ns: u64) -> AreaSet {
    match allowed.age_ns(now_ns) {
        Some(age_ns) if age_ns <= LEAVE_AGE_NS => allowed.value,
        _ => AreaSet::EMPTY,
    }
}

#[cfg(test)]
mod tests {
    use description::areas::AreaIndex;

    use super::*;

    #[test]
    fn leave_is_only_good_while_it_is_repeated() {
        let set: AreaSet = [1, 2].map(AreaIndex).into_iter().collect();
        let said = |stamp_ns| Stamped {
            stamp_ns,
            value: set,
        };
        assert_eq!(leave(&said(5), 5 + LEAVE_AGE_NS), set);
        assert_eq!(leave(&said(5), 6 + LEAVE_AGE_NS), AreaSet::EMPTY);
        assert_eq!(leave(&said(0), 1), AreaSet::EMPTY, "never written");
    }
}
