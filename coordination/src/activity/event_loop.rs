//! What an activity is, and the one order in which its parts run.

use super::life_cycle::{LifeCycle, LifeCycleState};

/// An activity: asynchronous towards others, synchronous inside.
///
/// Each method has a default that does nothing, so an activity writes only what it has. None may
/// block in [`LifeCycleState::Running`] on a real-time thread, apart from the activity's own
/// device. `now_ns` is the monotonic time at which this turn of the loop began, the same for all
/// of it.
pub trait Activity: Send {
    /// The activity's name, as in the robot file and in the symbol table.
    fn name(&self) -> &'static str;

    /// The activity's life cycle.
    fn life_cycle(&self) -> &LifeCycle;

    /// Communication, inwards: take over symbols, receive events, read the device. In every state.
    fn communicate_in(&mut self, now_ns: u64) {
        let _ = now_ns;
    }

    /// Coordination: step the life cycle and other machines on what was received. In every state.
    fn coordinate(&mut self, now_ns: u64) {
        let _ = now_ns;
    }

    /// Configuration: one step of acquiring resources or of taking over parameters; reports its
    /// end by stepping the life cycle. Only in the configuring states, where it may block.
    fn configure(&mut self, now_ns: u64) {
        let _ = now_ns;
    }

    /// Computation: the algorithms. Only while running.
    fn compute(&mut self, now_ns: u64) {
        let _ = now_ns;
    }

    /// What takes the place of computation while not running: bring outputs to rest. In every
    /// other state.
    fn rest(&mut self, now_ns: u64) {
        let _ = now_ns;
    }

    /// Communication, outwards: publish symbols, send events, write the device. In every state.
    fn communicate_out(&mut self, now_ns: u64) {
        let _ = now_ns;
    }
}

/// One turn of the loop: communicate, coordinate, configure, compute, communicate.
///
/// The state is looked at anew before each gated part, so an activity that coordination has just
/// paused does not compute any more, and one that has finished to configure rests until it is told
/// to run.
pub fn event_loop_once(activity: &mut dyn Activity, now_ns: u64) {
    activity.communicate_in(now_ns);
    activity.coordinate(now_ns);
    if activity.life_cycle().state().is_configuring() {
        activity.configure(now_ns);
    }
    if activity.life_cycle().state() == LifeCycleState::Running {
        activity.compute(now_ns);
    } else {
        activity.rest(now_ns);
    }
    activity.communicate_out(now_ns);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::activity::LifeCycleEvent;
    use crate::event::{Receiver, Sender, queue};

    /// Writes down which parts ran.
    struct Recorder {
        life: LifeCycle,
        inbox: Receiver<LifeCycleEvent>,
        ran: Vec<(&'static str, u64)>,
    }

    impl Recorder {
        fn new() -> (Sender<LifeCycleEvent>, Self) {
            let (sender, inbox) = queue(4);
            let life = LifeCycle::new();
            let ran = Vec::new();
            (sender, Self { life, inbox, ran })
        }

        fn turn(&mut self, now_ns: u64) -> Vec<&'static str> {
            self.ran.clear();
            event_loop_once(self, now_ns);
            assert!(self.ran.iter().all(|&(_, at)| at == now_ns));
            self.ran.iter().map(|&(part, _)| part).collect()
        }
    }

    impl Activity for Recorder {
        fn name(&self) -> &'static str {
            "recorder"
        }
        fn life_cycle(&self) -> &LifeCycle {
            &self.life
        }
        fn communicate_in(&mut self, now_ns: u64) {
            self.ran.push(("in", now_ns));
        }
        fn coordinate(&mut self, now_ns: u64) {
            self.ran.push(("coordinate", now_ns));
            while let Some(event) = self.inbox.receive() {
                self.life.step(event);
            }
        }
        fn configure(&mut self, now_ns: u64) {
            self.ran.push(("configure", now_ns));
            self.life.step(LifeCycleEvent::Configured);
        }
        fn compute(&mut self, now_ns: u64) {
            self.ran.push(("compute", now_ns));
        }
        fn rest(&mut self, now_ns: u64) {
            self.ran.push(("rest", now_ns));
        }
        fn communicate_out(&mut self, now_ns: u64) {
            self.ran.push(("out", now_ns));
        }
    }

    #[test]
    fn the_five_cs_run_in_order_and_as_the_life_cycle_allows() {
        let (mut commands, mut activity) = Recorder::new();
        assert_eq!(activity.turn(1), ["in", "coordinate", "rest", "out"]);

        commands.send(LifeCycleEvent::Configure).unwrap();
        assert_eq!(
            activity.turn(2),
            ["in", "coordinate", "configure", "rest", "out"]
        );
        assert_eq!(activity.life.state(), LifeCycleState::Ready);

        commands.send(LifeCycleEvent::Run).unwrap();
        assert_eq!(activity.turn(3), ["in", "coordinate", "compute", "out"]);

        commands.send(LifeCycleEvent::Pause).unwrap();
        assert_eq!(activity.turn(4), ["in", "coordinate", "rest", "out"]);
    }
}
