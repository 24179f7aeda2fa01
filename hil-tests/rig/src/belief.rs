//! What a robot believes, read from its symbols as any program of the same user can.

use coordination::symbols::{Inspector, Namespace, Reader};
use onboard::symbols::faults::{FAULTS, Fault, FaultState, FaultTable};
use onboard::symbols::values::{LidarStatus, NavigationState, PoseEstimate, RangeScan, TubeState};
use sim::world::Pose;
use skills::schedule::Hold;

/// Reads the symbols of one running robot.
pub struct Insight {
    pose: Reader<PoseEstimate>,
    navigation: Reader<NavigationState>,
    tubes: Reader<TubeState>,
    faults: Reader<FaultTable>,
    scan: Reader<RangeScan>,
    lidar: Reader<LidarStatus>,
    ahead_ns: i64,
}

/// What the robot believes at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Belief {
    /// Time of the estimate, by the world's clock; 0 before the first.
    pub stamp_ns: u64,
    /// `base_link` in `map`.
    pub pose: Pose,
    /// Standard deviations of x, y and heading.
    pub std: [f64; 3],
    /// It says that its pose is too uncertain.
    pub uncertain: bool,
    /// State of its machine.
    pub state: String,
    /// Area of that state.
    pub area: String,
    /// Skill that runs.
    pub skill: String,
    /// What the motion tubes make of the command: free, shifted, slowed, stopped.
    pub verdict: u64,
    /// Why, as a number of the tubes' reasons.
    pub reason: u64,
    /// Why navigation does not go on, and the area that it waits for, in words; empty while it goes on.
    pub hold: String,
    /// Something keeps it from driving that has nothing to do with where it wants to go: a fault, an operator, or what stands in
    /// its way.
    pub kept: bool,
}

impl Belief {
    /// The motion tubes have stopped it for want of room; other reasons, such as no scan yet, are not of interest.
    #[must_use]
    pub fn is_held(&self) -> bool {
        self.verdict == 3 && matches!(self.reason, 1 | 3 | 6)
    }
}

impl Insight {
    /// Opens its symbols.
    ///
    /// # Errors
    /// A sentence when the robot does not run, or not yet.
    pub fn open(robot: &str, place: &Namespace) -> Result<Self, String> {
        let inspector = Inspector::open(robot, place).map_err(|error| error.to_string())?;
        let text = |error: coordination::symbols::SymbolError| error.to_string();
        Ok(Self {
            pose: inspector.reader("map").map_err(text)?,
            navigation: inspector.reader("robot").map_err(text)?,
            tubes: inspector.reader("adaptive").map_err(text)?,
            faults: inspector.reader("robot").map_err(text)?,
            scan: inspector.reader("hokuyo").map_err(text)?,
            lidar: inspector.reader("hokuyo").map_err(text)?,
            ahead_ns: 0,
        })
    }

    /// So far the robot's clock is ahead of the world's now. What is read is told by the world's.
    pub fn set_ahead(&mut self, ahead_ns: i64) {
        self.ahead_ns = ahead_ns;
    }

    /// A time of the robot's clock by the world's; 0 is "never" on both.
    fn in_the_world(&self, own_ns: u64) -> u64 {
        if own_ns == 0 {
            return 0;
        }
        own_ns.saturating_add_signed(-self.ahead_ns).max(1)
    }

    /// What it believes now.
    pub fn look(&mut self) -> Belief {
        let pose = self.pose.read();
        let navigation = self.navigation.read().value;
        let tubes = self.tubes.read().value;
        let faulty = self.faults.read().value.active().any(stops);
        let forbidden = [Hold::Forbidden, Hold::PoseUncertain].map(Hold::reason);
        let hold = navigation.hold;
        let mut belief = Belief {
            stamp_ns: self.in_the_world(pose.stamp_ns),
            pose: Pose::new(
                pose.value.pose.x_m,
                pose.value.pose.y_m,
                pose.value.pose.theta_rad,
            ),
            std: [
                pose.value.std_x_m,
                pose.value.std_y_m,
                pose.value.std_theta_rad,
            ],
            uncertain: pose.value.uncertain != 0,
            state: navigation.state.as_str().to_owned(),
            area: navigation.area.as_str().to_owned(),
            skill: navigation.skill.as_str().to_owned(),
            verdict: tubes.verdict,
            reason: tubes.reason,
            hold: [navigation.hold, navigation.waiting_for]
                .map(|name| name.as_str().to_owned())
                .join(" ")
                .trim()
                .to_owned(),
            kept: faulty || forbidden.contains(&hold.as_str()),
        };
        belief.kept |= belief.is_held();
        belief
    }

    /// When the first beam of its newest scan was measured, by its own clock; 0 before the first.
    pub fn scan_stamp_ns(&mut self) -> u64 {
        self.scan.read().stamp_ns
    }

    /// What it says of its lidar.
    pub fn lidar(&mut self) -> LidarStatus {
        self.lidar.read().value
    }

    /// The faults that it has had, and has.
    pub fn faults(&mut self) -> FaultTable {
        let mut states: [FaultState; FAULTS] = bytemuck::cast(self.faults.read().value);
        for state in &mut states {
            state.since_ns = self.in_the_world(state.since_ns);
        }
        bytemuck::cast(states)
    }
}

/// Whether a robot with this fault stands, or comes to stand.
fn stops(fault: Fault) -> bool {
    !matches!(
        fault,
        Fault::ScanBroken
            | Fault::EncoderImplausible
            | Fault::QueueFull
            | Fault::OffLane
            | Fault::FleetNetwork
            | Fault::MediatorSilent
            | Fault::MediatorRefused
            | Fault::IdentityDoubled
            | Fault::SecondMediator
    )
}
