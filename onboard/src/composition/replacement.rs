//! What a reload exchanges in a running robot: new gains, limits, tubes and map.

use coordination::fsm::Machine;
use skills::drive::WheelController;
use skills::tubes::MotionTubes;

use super::failure::Failure;
use super::files::Files;
use super::plan::{Plan, PlanError};
use crate::activities::exchange::{Exchange, Hand};
use crate::activities::navigation;

/// What the files were made into: parts for the activities that are reconfigured.
pub struct Replacement {
    plan: Plan,
    navigator: Box<navigation::Part>,
    tubes: Box<MotionTubes>,
    controller: Box<WheelController>,
    machine: Machine,
}

impl Replacement {
    /// Reads and checks the files and builds everything.
    ///
    /// # Errors
    /// The reason why a robot that runs `present` cannot go on by the files.
    pub fn prepare(files: &Files, present: &Plan) -> Result<Self, String> {
        let plan = Plan::load(files).map_err(|failure| match failure {
            Failure::Refused(report) | Failure::Failed(report) => format!("{report:?}"),
        })?;
        if let Some(key) = present.first_fixed_difference(&plan) {
            return Err(format!(
                "`{key}` has changed, which takes a restart; [navigation], [tubes], [teleop], gains in [control], limits of \
                 speed, steering and acceleration in [drive], and the site can be reloaded"
            ));
        }
        let state = |name: &str| plan.fsm.state(name).is_some();
        if let Some(gone) = present.fsm.states.iter().find(|own| !state(&own.name)) {
            return Err(format!(
                "the robot may be in state `{}`, which the new state machine does not have; that takes a restart",
                gone.name
            ));
        }
        let text = |error: PlanError| error.to_string();
        let navigator = plan.navigator().map_err(text)?;
        let start = plan.start(navigator.machine().state());
        let machine = navigator.machine().clone();
        Ok(Self {
            navigator: Box::new(navigation::Part::new(
                Box::new(navigator),
                start,
                plan.robot.teleop,
            )),
            tubes: Box::new(plan.motion_tubes().map_err(text)?),
            controller: Box::new({ plan.wheel_controller() }.map_err(|error| error.to_string())?),
            machine,
            plan,
        })
    }
}

/// The activities' ends.
pub struct ReloadEnds {
    /// Of navigation.
    pub navigator: Exchange<navigation::Part>,
    /// Of the motion tube.
    pub tubes: Exchange<MotionTubes>,
    /// Of control.
    pub controller: Exchange<WheelController>,
}

/// The supervisor's ends.
pub struct ReloadHands {
    navigator: Hand<navigation::Part>,
    tubes: Hand<MotionTubes>,
    controller: Hand<WheelController>,
}

impl ReloadHands {
    /// Both sides' ends.
    #[must_use]
    pub fn pair() -> (Self, ReloadEnds) {
        let (navigator, navigator_end) = Hand::pair();
        let (tubes, tubes_end) = Hand::pair();
        let (controller, controller_end) = Hand::pair();
        let hands = Self {
            navigator,
            tubes,
            controller,
        };
        let ends = ReloadEnds {
            navigator: navigator_end,
            tubes: tubes_end,
            controller: controller_end,
        };
        (hands, ends)
    }

    /// Hands the parts to their activities; gives back the plan they were made of, and the machine, for its names.
    pub fn hand_over(&mut self, replacement: Replacement) -> (Plan, Machine) {
        self.navigator.hand_over(replacement.navigator);
        self.tubes.hand_over(replacement.tubes);
        self.controller.hand_over(replacement.controller);
        (replacement.plan, replacement.machine)
    }

    /// Whether every activity has taken its part.
    #[must_use]
    pub fn taken(&self) -> bool {
        self.navigator.taken() && self.tubes.taken() && self.controller.taken()
    }

    /// Releases the parts that came back.
    pub fn release_old(&mut self) {
        self.navigator.release_old();
        self.tubes.release_old();
        self.controller.release_old();
    }
}
