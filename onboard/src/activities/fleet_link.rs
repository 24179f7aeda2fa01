//! The queues between communication and navigation on a managed site: what the mediator orders, and what became of it.
//!
//! Real-time contract: after construction nothing on navigation's end allocates, locks or blocks. Its one system call wakes
//! communication.

use coordination::event::{EventId, Receiver, Sender, queue};
use skills::navigator::Instructed;

use crate::fleet::Directive;
use crate::realtime::wake::Wake;

/// Capacity of the queue to navigation.
const ORDERS: usize = 16;
/// Capacity of the queue from navigation.
const EVENTS: usize = 128;

/// What navigation says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NavigationEvent {
    /// The machine fired an output.
    Output(EventId),
    /// What became of [`Directive::Instruct`].
    Instructed(Instructed),
    /// [`Directive::Resume`] is carried out, and the whereabouts in the table say so.
    Relocated,
}

/// Navigation's end.
#[derive(Debug)]
pub struct NavigationEnd {
    /// What to do.
    pub orders: Receiver<Directive>,
    /// What became of it.
    pub events: Sender<NavigationEvent>,
    /// Wakes communication.
    pub wake: Wake,
}

/// Communication's end.
#[derive(Debug)]
pub struct CommunicationEnd {
    /// What to do.
    pub orders: Sender<Directive>,
    /// What became of it.
    pub events: Receiver<NavigationEvent>,
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
