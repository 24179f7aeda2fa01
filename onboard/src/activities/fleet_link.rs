//! The queues between communication and navigation on a managed site: what the mediator orders, and what became of it.
//!
//! Real-time contract: after construction nothing on navigation's end allocates, locks or blocks. Its one system call wakes
//! communication.

use coordination::event::{EventId, Receiver, Sender, queue};
use coordination::fsm::StateId;
use description::geometry::Pose2;
use skills::navigator::Instruction;

use crate::fleet::Answer;
use crate::realtime::wake::Wake;

/// Capacity of the queue to navigation.
const ORDERS: usize = 16;
/// Capacity of the queue from navigation.
const EVENTS: usize = 128;

/// What navigation is to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order {
    /// Give the machine this event.
    Instruct(Instruction),
    /// Drive no faster than this until told otherwise.
    LimitSpeed(Option<f64>),
    /// The robot is there, in that state.
    Relocate {
        /// In `map`.
        pose: Pose2,
        /// Standard deviation of the position; navigation knows none to be smaller than at its start.
        std_m: f64,
        /// Of the heading, as well.
        std_rad: f64,
        /// State of the machine.
        state: StateId,
    },
}

/// What navigation says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// The machine fired an output.
    Output(EventId),
    /// What became of [`Order::Instruct`].
    Answer(Answer),
    /// [`Order::Relocate`] is carried out, and the whereabouts in the table say so.
    Relocated,
}

/// Navigation's end.
#[derive(Debug)]
pub struct NavigationEnd {
    /// What to do.
    pub orders: Receiver<Order>,
    /// What became of it.
    pub events: Sender<Event>,
    /// Wakes communication.
    pub wake: Wake,
}

/// Communication's end.
#[derive(Debug)]
pub struct CommunicationEnd {
    /// What to do.
    pub orders: Sender<Order>,
    /// What became of it.
    pub events: Receiver<Event>,
}

/// Both ends. `wake` wakes the thread of communication.
#[must_use]
pub fn link(wake: Wake) -> (NavigationEnd, CommunicationEnd) {
    let (order_sender, orders) = queue(ORDERS);
    let (events, event_receiver) = queue(EVENTS);
    let navigation = NavigationEnd {
        orders,
        events,
        wake,
    };
    let communication = CommunicationEnd {
        orders: order_sender,
        events: event_receiver,
    };
    (navigation, communication)
}
