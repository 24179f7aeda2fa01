//! `onboard ctl reload`: new gains, tubes and map for a running robot, all or nothing.
//!
//! The files are read, checked and made into new parts on the main thread. Only then is the robot paused; once it
//! stands, navigation and motion tube swap the parts in state *reconfiguring* and hand the old ones back, so that
//! no real-time thread allocates or releases anything.

use rtrb::{Consumer, Producer, RingBuffer};
use skills::navigator::Navigator;
use skills::tubes::MotionTubes;

use crate::cli::{Failure, Files};
use crate::ctl::Pending;
use crate::plan::Plan;

/// An activity's end: takes a new part and gives the old one back.
pub struct Exchange<T> {
    new: Consumer<Box<T>>,
    old: Producer<Box<T>>,
}

impl<T> Exchange<T> {
    /// The new part, if there is one.
    pub fn take(&mut self) -> Option<Box<T>> {
        self.new.pop().ok()
    }

    /// Gives the old part back. There is room: parts are handed out one at a time.
    pub fn give_back(&mut self, old: Box<T>) {
        if let Err(rtrb::PushError::Full(old)) = self.old.push(old) {
            // Never released on this thread.
            std::mem::forget(old);
        }
    }
}

/// The supervisor's end.
struct Hand<T> {
    new: Producer<Box<T>>,
    old: Consumer<Box<T>>,
}

impl<T> Hand<T> {
    fn pair() -> (Self, Exchange<T>) {
        let (new, new_end) = RingBuffer::new(1);
        let (old_end, old) = RingBuffer::new(2);
        (
            Self { new, old },
            Exchange {
                new: new_end,
                old: old_end,
            },
        )
    }

    fn hand_over(&mut self, part: Box<T>) {
        // Empty: one reload at a time, and each waits until its part was taken.
        let _ = self.new.push(part);
    }

    fn release_old(&mut self) {
        while self.old.pop().is_ok() {}
    }
}

/// The activities' ends.
pub struct ReloadEnds {
    /// Of navigation.
    pub navigator: Exchange<Navigator>,
    /// Of the motion tube.
    pub tubes: Exchange<MotionTubes>,
}

/// A reload that is under way.
struct Prepared {
    parts: Option<(Box<Navigator>, Box<MotionTubes>)>,
    plan: Plan,
    pending: Pending,
}

/// The supervisor's side of reloading.
pub struct Reload {
    files: Files,
    plan: Plan,
    navigator: Hand<Navigator>,
    tubes: Hand<MotionTubes>,
    prepared: Option<Prepared>,
}

impl Reload {
    /// For a robot that runs `plan`, read from `files`.
    #[must_use]
    pub fn new(files: Files, plan: &Plan) -> (Self, ReloadEnds) {
        let (navigator, navigator_end) = Hand::pair();
        let (tubes, tubes_end) = Hand::pair();
        let reload = Self {
            files,
            plan: plan.clone(),
            navigator,
            tubes,
            prepared: None,
        };
        (
            reload,
            ReloadEnds {
                navigator: navigator_end,
                tubes: tubes_end,
            },
        )
    }

    /// Reads and checks the files and builds the new parts; on failure nothing changes and the reason comes back.
    ///
    /// # Errors
    /// The request, to be answered, with the reason.
    pub fn begin(&mut self, pending: Pending) -> Result<(), (Pending, String)> {
        match self.prepare() {
            Ok((plan, navigator, tubes)) => {
                self.prepared = Some(Prepared {
                    parts: Some((navigator, tubes)),
                    plan,
                    pending,
                });
                Ok(())
            }
            Err(why) => Err((pending, why)),
        }
    }

    fn prepare(&self) -> Result<(Plan, Box<Navigator>, Box<MotionTubes>), String> {
        if self.in_progress() {
            return Err("another reload is under way".into());
        }
        let plan = Plan::load(&self.files).map_err(|failure| match failure {
            Failure::Refused(report) | Failure::Failed(report) => format!("{report:?}"),
        })?;
        if let Some(section) = self.plan.first_fixed_difference(&plan) {
            return Err(format!(
                "`{section}` has changed, which takes a restart; only [navigation], [tubes] and the site can be reloaded"
            ));
        }
        if let Some(gone) = self
            .plan
            .fsm
            .states
            .iter()
            .find(|state| plan.fsm.state(&state.name).is_none())
        {
            return Err(format!(
                "the robot may be in state `{}`, which the new state machine does not have",
                gone.name
            ));
        }
        let navigator = plan.navigator().map_err(|error| error.to_string())?;
        let tubes = plan.motion_tubes().map_err(|error| error.to_string())?;
        Ok((plan, Box::new(navigator), Box::new(tubes)))
    }

    /// Whether a reload is under way.
    #[must_use]
    pub fn in_progress(&self) -> bool {
        self.prepared.is_some()
    }

    /// Whether the parts were handed over.
    #[must_use]
    pub fn handed_over(&self) -> bool {
        self.prepared
            .as_ref()
            .is_some_and(|prepared| prepared.parts.is_none())
    }

    /// Hands the parts over.
    pub fn hand_over(&mut self) {
        if let Some((navigator, tubes)) = self
            .prepared
            .as_mut()
            .and_then(|prepared| prepared.parts.take())
        {
            self.navigator.hand_over(navigator);
            self.tubes.hand_over(tubes);
        }
    }

    /// Whether both activities have taken their parts: the old ones are back.
    #[must_use]
    pub fn taken(&self) -> bool {
        !self.navigator.old.is_empty() && !self.tubes.old.is_empty()
    }

    /// Ends the reload; gives the names of the new machine's states.
    pub fn finish(&mut self) -> Option<Vec<String>> {
        self.navigator.release_old();
        self.tubes.release_old();
        let prepared = self.prepared.take()?;
        self.plan = prepared.plan;
        prepared.pending.answer(&Ok("reloaded".into()));
        Some(
            self.plan
                .fsm
                .states
                .iter()
                .map(|state| state.name.clone())
                .collect(),
        )
    }
}
