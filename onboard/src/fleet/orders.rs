//! Orders of the mediator on their way to navigation, each until the robot's machine has taken it.

use std::collections::VecDeque;

use contract::client::Order;
use contract::protocols::RELEASE;
use coordination::fsm::StateId;
use skills::navigator::{Instructed, Instruction, InstructionError};

use super::setup::StatePlan;

/// Navigation is asked again when it has not answered for this long.
const ANSWER_NS: u64 = 1_000_000_000;
/// Orders that may wait; a coordination has far fewer.
const MOST: usize = 64;

/// What navigation is to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Directive {
    /// Give the machine this event, with what holds in the state that it leads to.
    Instruct(Instruction),
    /// Drive no faster than this until told otherwise; 0 stands.
    LimitSpeed(Option<f64>),
    /// Go on in this state of the machine, where navigation takes the robot to be.
    Resume(StateId),
}

/// Orders that were not carried out yet.
#[derive(Clone, Debug, Default)]
pub(super) struct Orders {
    waiting: VecDeque<Order>,
    /// When the first of them was handed to navigation.
    asked_ns: Option<u64>,
    /// An order without an event has limited the speed.
    limits: bool,
    /// For people.
    complaints: Vec<String>,
}

impl Orders {
    pub(super) fn add(&mut self, order: Order) {
        if self.waiting.len() == MOST {
            self.drop_first("too many orders wait");
        }
        self.waiting.push_back(order);
    }

    /// The next thing for navigation to do, in a state of the machine.
    pub(super) fn next(&mut self, state: Option<&StatePlan>, now_ns: u64) -> Option<Directive> {
        if let Some(asked_ns) = self.asked_ns {
            if now_ns < asked_ns.saturating_add(ANSWER_NS) {
                return None;
            }
            self.asked_ns = None;
        }
        loop {
            let order = self.waiting.front()?;
            let Some(event) = order.instruction.event.clone() else {
                let order = self.waiting.pop_front()?;
                if let Some(directive) = self.without_event(&order) {
                    return Some(directive);
                }
                continue;
            };
            let state = state?;
            if let Some(number) = state.accepts(&event) {
                if self.limits {
                    // A limit that holds until the next order ends with it.
                    self.limits = false;
                    return Some(Directive::LimitSpeed(None));
                }
                self.asked_ns = Some(now_ns);
                return Some(Directive::Instruct(order.instruction.with_event(number)));
            }
            if order.repeated || order.flag == RELEASE {
                // The machine took the event before the robot restarted; or the robot drives on by itself, and there is
                // nothing to resume.
                self.waiting.pop_front();
            } else if self.waiting.len() > 1 {
                let why = format!(
                    "state `{}` has no use for `{event}`, and the next order has come",
                    state.name
                );
                self.drop_first(&why);
            } else {
                return None;
            }
        }
    }

    fn without_event(&mut self, order: &Order) -> Option<Directive> {
        if order.instruction.stop_at.is_some() {
            // A place to stop belongs to a state. The robot stands rather than drive past one that it cannot keep.
            self.complain(order, "it has a place to stop but no event: standing still");
            self.limits = true;
            return Some(Directive::LimitSpeed(Some(0.0)));
        }
        let limit_m_s = order.instruction.speed_limit_m_s;
        (std::mem::replace(&mut self.limits, limit_m_s.is_some()) || limit_m_s.is_some())
            .then_some(Directive::LimitSpeed(limit_m_s))
    }

    /// What navigation says to the last [`Directive::Instruct`].
    pub(super) fn answered(&mut self, answer: Instructed) {
        if self.asked_ns.take().is_none() {
            return;
        }
        match answer {
            Instructed::Taken { .. } => {
                self.waiting.pop_front();
            }
            // It was in another state by then, or there was no room: it is asked again.
            Instructed::Ignored { .. }
            | Instructed::NotReady
            | Instructed::Refused(InstructionError::Full) => {}
            Instructed::Refused(error) => self.drop_first(&error.to_string()),
        }
    }

    /// The robot was released.
    pub(super) fn released(&mut self) -> Option<Directive> {
        std::mem::take(&mut self.limits).then_some(Directive::LimitSpeed(None))
    }

    /// The first order that waits, for people.
    pub(super) fn first(&self) -> Option<&Order> {
        self.waiting.front()
    }

    pub(super) fn next_complaint(&mut self) -> Option<String> {
        self.complaints.pop()
    }

    fn drop_first(&mut self, why: &str) {
        self.asked_ns = None;
        if let Some(order) = self.waiting.pop_front() {
            self.complain(&order, why);
        }
    }

    fn complain(&mut self, order: &Order, why: &str) {
        if self.complaints.len() < MOST {
            self.complaints.push(format!(
                "order `{}` of coordination {} is not carried out: {why}",
                order.flag, order.coordination
            ));
        }
    }
}

#[cfg(test)]
mod tests {
    use coordination::event::EventId;
    use coordination::fsm::StateId;
    use description::geometry::Pose2;

    use super::*;

    const TAKEN: Instructed = Instructed::Taken {
        from: StateId(0),
        to: StateId(1),
        hold: None,
    };

    fn order(flag: &str, event: Option<&str>, speed_limit_m_s: Option<f64>) -> Order {
        Order {
            coordination: 1,
            flag: flag.into(),
            instruction: description::instruction::Instruction {
                event: event.map(str::to_owned),
                speed_limit_m_s,
                stop_at: None,
            },
            repeated: false,
        }
    }

    /// Events of the test's machine have the length of their names for numbers.
    fn number(event: &str) -> EventId {
        EventId(u16::try_from(event.len()).expect("short"))
    }

    fn state(accepts: &str) -> StatePlan {
        StatePlan {
            name: "drive-1".into(),
            accepts: vec![(accepts.to_owned(), number(accepts))],
            ..StatePlan::default()
        }
    }

    fn instruct(event: &str) -> Option<Directive> {
        Some(Directive::Instruct(Instruction::plain(number(event))))
    }

    #[test]
    fn an_order_waits_for_its_state_and_is_asked_until_it_is_taken() {
        let mut orders = Orders::default();
        orders.add(order("e5", Some("aside"), None));
        assert_eq!(orders.next(Some(&state("other")), 0), None);
        assert_eq!(orders.next(Some(&state("aside")), 1), instruct("aside"));
        assert_eq!(
            orders.next(Some(&state("aside")), 2),
            None,
            "it is on its way"
        );
        orders.answered(Instructed::NotReady);
        assert_eq!(orders.next(Some(&state("aside")), 3), instruct("aside"));
        // No answer at all.
        assert_eq!(
            orders.next(Some(&state("aside")), 3 + ANSWER_NS),
            instruct("aside")
        );
        orders.answered(TAKEN);
        assert_eq!(orders.next(Some(&state("aside")), 4 + ANSWER_NS), None);
        assert!(orders.next_complaint().is_none());
    }

    #[test]
    fn what_a_restarted_robot_has_taken_before_is_left_out() {
        let mut orders = Orders::default();
        orders.add(Order {
            repeated: true,
            ..order("e5", Some("aside"), None)
        });
        assert_eq!(orders.next(Some(&state("other")), 0), None);
        assert!(orders.first().is_none() && orders.next_complaint().is_none());
    }

    #[test]
    fn a_robot_that_drives_on_by_itself_has_nothing_to_resume() {
        let mut orders = Orders::default();
        orders.add(order(RELEASE, Some("resume"), None));
        assert_eq!(orders.next(Some(&state("resume")), 0), instruct("resume"));
        orders.answered(TAKEN);
        // It must not be resumed some day, in the middle of another coordination.
        orders.add(order(RELEASE, Some("resume"), None));
        assert_eq!(orders.next(Some(&state("other")), 1), None);
        assert!(orders.first().is_none() && orders.next_complaint().is_none());
    }

    #[test]
    fn an_order_that_came_too_late_gives_way_and_is_told() {
        let mut orders = Orders::default();
        orders.add(order("e1", Some("aside"), None));
        orders.add(order("e2", Some("back"), None));
        assert_eq!(orders.next(Some(&state("back")), 0), instruct("back"));
        let complaint = orders.next_complaint().expect("told");
        assert!(
            complaint.contains("`e1`") && complaint.contains("drive-1"),
            "{complaint}"
        );
        orders.answered(Instructed::Refused(InstructionError::StopPose));
        assert!(orders.next_complaint().expect("told").contains("`e2`"));
    }

    #[test]
    fn a_speed_limit_without_an_event_holds_until_the_next_order_or_the_release() {
        let mut orders = Orders::default();
        orders.add(order("e1", None, Some(0.1)));
        assert_eq!(orders.next(None, 0), Some(Directive::LimitSpeed(Some(0.1))));
        orders.add(order("e2", Some("go"), None));
        assert_eq!(
            orders.next(Some(&state("go")), 1),
            Some(Directive::LimitSpeed(None))
        );
        assert_eq!(orders.next(Some(&state("go")), 1), instruct("go"));
        assert_eq!(orders.released(), None);
        orders.answered(TAKEN);
        orders.add(order("e3", None, Some(0.2)));
        assert_eq!(orders.next(None, 2), Some(Directive::LimitSpeed(Some(0.2))));
        assert_eq!(orders.released(), Some(Directive::LimitSpeed(None)));
    }

    #[test]
    fn a_place_to_stop_without_an_event_is_not_driven_past() {
        let mut orders = Orders::default();
        let mut stop = order("e1", None, None);
        stop.instruction.stop_at = Some(Pose2::default());
        orders.add(stop);
        assert_eq!(orders.next(None, 0), Some(Directive::LimitSpeed(Some(0.0))));
        assert!(orders.next_complaint().is_some());
    }
}
