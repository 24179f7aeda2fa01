//! The robot's session on the fleet's network, whatever carries it.

use super::mailbox::Inbox;

/// An open session, on which the robot is alive; closes when it is dropped.
pub trait Session: Send {
    /// The session's own name.
    fn id(&self) -> String;

    /// Sends the robot's state to everybody. Does not wait.
    ///
    /// # Errors
    /// A sentence.
    fn send_state(&self, message: Vec<u8>) -> Result<(), String>;

    /// Sends a report to the mediator. Does not wait.
    ///
    /// # Errors
    /// A sentence.
    fn send_report(&self, message: Vec<u8>) -> Result<(), String>;
}

/// Opens a session, at first and after each failure. On a managed site the inbox takes the mediator's messages.
pub type OpenSession = Box<dyn FnMut(Option<Inbox>) -> Result<Box<dyn Session>, String> + Send>;
