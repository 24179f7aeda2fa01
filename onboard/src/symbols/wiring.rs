//! The wiring: which symbols there are, which activity owns each, which read it. One place, for `run` and `check`.
//!
//! A new symbol is one line with `Writer` at its owner and one with `Reader` at each reader.

use coordination::symbols::{
    Datatype, Namespace, Reader, SymbolError, SymbolTable, TableBuilder, Writer,
};
use description::threads::ActivityKind;
use skills::borders::AreaSet;
use skills::odometry::Odometry;
use skills::tubes::FloorCheckpoint;

use super::faults::FaultTable;
use super::values::{
    ActivityState, DriveStatus, Encoders, FleetState, LidarStatus, Load, NavigationState,
    OdometryTrace, PoseEstimate, RangeScan, RobotMode, SafeCommand, TeleopWish, ThreadReport,
    TubeState, WantedMotion, WheelSetpoints, Whereabouts,
};

const SUPERVISOR: &str = "supervisor";
const TELEOP: &str = "teleop";

/// Activities, in the order in which data flows.
pub const ACTIVITIES: [ActivityKind; 7] = [
    ActivityKind::Drive,
    ActivityKind::Proprioception,
    ActivityKind::Lidar,
    ActivityKind::Navigation,
    ActivityKind::MotionTube,
    ActivityKind::Control,
    ActivityKind::Communication,
];

/// Activities that look at scans.
const SCAN_READERS: [ActivityKind; 2] = [ActivityKind::Navigation, ActivityKind::MotionTube];

/// One end of a symbol.
trait End: Sized {
    /// Declares the symbol, at the end that owns it.
    fn declare(builder: &mut TableBuilder, user: &str, model: &str) -> Result<(), SymbolError>;

    /// Takes this end.
    fn take(table: &SymbolTable, user: &str, model: &str) -> Result<Self, SymbolError>;
}

impl<T: Datatype> End for Writer<T> {
    fn declare(builder: &mut TableBuilder, user: &str, model: &str) -> Result<(), SymbolError> {
        builder.declare::<T>(user, model).map(|_| ())
    }

    fn take(table: &SymbolTable, user: &str, model: &str) -> Result<Self, SymbolError> {
        table.writer(user, model)
    }
}

impl<T: Datatype> End for Reader<T> {
    fn declare(_: &mut TableBuilder, _: &str, _: &str) -> Result<(), SymbolError> {
        Ok(())
    }

    fn take(table: &SymbolTable, user: &str, model: &str) -> Result<Self, SymbolError> {
        table.reader(user, model)
    }
}

/// For each user of symbols a structure of their ends: `field: Writer<T> | Reader<T> => "model"`.
macro_rules! users {
    ($($(#[$meta:meta])* $name:ident, $user:expr, {
        $($(#[$field_meta:meta])* $field:ident: $end:ty => $model:literal,)*
    })*) => {
        $(
            $(#[$meta])*
            #[derive(Debug)]
            pub struct $name { $($(#[$field_meta])* pub $field: $end,)* }

            impl $name {
                fn declare(builder: &mut TableBuilder) -> Result<(), SymbolError> {
                    $(<$end as End>::declare(builder, $user, $model)?;)*
                    Ok(())
                }

                fn take(table: &SymbolTable) -> Result<Self, SymbolError> {
                    Ok(Self { $($field: End::take(table, $user, $model)?,)* })
                }
            }
        )*
    };
}

users! {
    /// Symbols of the drive activity.
    DriveSymbols, ActivityKind::Drive.name(), {
        /// What control wants.
        setpoints: Reader<WheelSetpoints> => "kelo",
        /// What the encoders say.
        encoders: Writer<Encoders> => "kelo",
        /// What the bus and the drive are doing.
        status: Writer<DriveStatus> => "kelo",
    }

    /// Symbols of the proprioception activity.
    ProprioceptionSymbols, ActivityKind::Proprioception.name(), {
        /// Wheel and pivot encoders.
        encoders: Reader<Encoders> => "kelo",
        /// Pose and twist in `odom`.
        odometry: Writer<Odometry> => "odom",
        /// The same, for the last third of a second.
        trace: Writer<OdometryTrace> => "odom",
    }

    /// Symbols of the lidar activity.
    LidarSymbols, ActivityKind::Lidar.name(), {
        /// The last scan.
        scan: Writer<RangeScan> => "hokuyo",
        /// State of the device.
        status: Writer<LidarStatus> => "hokuyo",
        /// To know whether its scans are frozen: who knows how the robot moved says so.
        tube: Reader<TubeState> => "adaptive",
    }

    /// Symbols of the navigation activity.
    NavigationSymbols, ActivityKind::Navigation.name(), {
        /// Dead reckoning.
        odometry: Reader<Odometry> => "odom",
        /// Whether somebody drives by hand.
        mode: Reader<RobotMode> => "robot",
        /// What a teleoperator wants.
        wish: Reader<TeleopWish> => "teleop",
        /// Pose in `map`.
        pose: Writer<PoseEstimate> => "map",
        /// State, area, skill.
        state: Writer<NavigationState> => "robot",
        /// Where it is and what it does there, in numbers.
        whereabouts: Writer<Whereabouts> => "map",
        /// The motion that it wants.
        command: Writer<WantedMotion> => "wanted",
    }

    /// Symbols of navigation that only a managed site needs.
    NavigationFleetSymbols, ActivityKind::Navigation.name(), {
        /// Where the robot may be.
        allowed: Reader<AreaSet> => "fleet",
    }

    /// Symbols of the communication activity.
    CommunicationSymbols, ActivityKind::Communication.name(), {
        /// Pose in `map`.
        pose: Reader<PoseEstimate> => "map",
        /// Speeds.
        odometry: Reader<Odometry> => "odom",
        /// State, area and skill.
        navigation: Reader<NavigationState> => "robot",
        /// Faults of the whole robot.
        faults: Reader<FaultTable> => "robot",
        /// What the robot is doing.
        mode: Reader<RobotMode> => "robot",
        /// The battery's voltage.
        drive: Reader<DriveStatus> => "kelo",
        /// What it carries.
        load: Reader<Load> => "robot",
    }

    /// Symbols of communication that only a managed site needs.
    CommunicationFleetSymbols, ActivityKind::Communication.name(), {
        /// Where the robot is, in numbers.
        whereabouts: Reader<Whereabouts> => "map",
        /// Where it may be.
        allowed: Writer<AreaSet> => "fleet",
        /// How it stands with the mediator.
        state: Writer<FleetState> => "fleet",
    }

    /// Symbols of the motion tube activity.
    MotionTubeSymbols, ActivityKind::MotionTube.name(), {
        /// Dead reckoning.
        odometry: Reader<Odometry> => "odom",
        /// What navigation wants.
        wanted: Reader<WantedMotion> => "wanted",
        /// To know that the supervisor lives.
        mode: Reader<RobotMode> => "robot",
        /// What is safe.
        safe: Writer<SafeCommand> => "safe",
        /// What the tubes made of the wanted motion, and why.
        state: Writer<TubeState> => "adaptive",
        /// What is remembered of the floor around the robot.
        floor: Writer<FloorCheckpoint> => "adaptive",
    }

    /// Symbols of the control activity.
    ControlSymbols, ActivityKind::Control.name(), {
        /// The command that the motion tubes let through.
        command: Reader<SafeCommand> => "safe",
        /// Where wheels and pivot are.
        encoders: Reader<Encoders> => "kelo",
        /// Whether the drive follows.
        drive: Reader<DriveStatus> => "kelo",
        /// What the wheels are to do.
        setpoints: Writer<WheelSetpoints> => "kelo",
    }

    /// Symbols of the desk at which a teleoperator sits.
    TeleopSymbols, TELEOP, {
        /// What is wanted.
        wish: Writer<TeleopWish> => "teleop",
        /// Whether the robot is in the teleoperator's hands. The rest is for people:
        mode: Reader<RobotMode> => "robot",
        /// faults,
        faults: Reader<FaultTable> => "robot",
        /// pose,
        pose: Reader<PoseEstimate> => "map",
        /// borders,
        navigation: Reader<NavigationState> => "robot",
        /// what navigation lets through of the wish,
        wanted: Reader<WantedMotion> => "wanted",
        /// what the tubes let through of that,
        safe: Reader<SafeCommand> => "safe",
        /// and why not more,
        tube: Reader<TubeState> => "adaptive",
        /// and how the robot moves.
        odometry: Reader<Odometry> => "odom",
    }

    /// Symbols of the supervisor.
    SupervisorSymbols, SUPERVISOR, {
        /// Faults of the whole robot.
        faults: Writer<FaultTable> => "robot",
        /// What the robot is doing.
        mode: Writer<RobotMode> => "robot",
        /// What it carries, by an operator's word.
        load: Writer<Load> => "robot",
        /// To know whether a teleoperator is connected.
        wish: Reader<TeleopWish> => "teleop",
        /// To know when it stands.
        encoders: Reader<Encoders> => "kelo",
        /// To know whether there is a bus to stop it with.
        drive: Reader<DriveStatus> => "kelo",
        /// For who has said where it stands: what scans say of that.
        pose: Reader<PoseEstimate> => "map",
        /// For the checkpoint: dead reckoning,
        odometry: Reader<Odometry> => "odom",
        /// where the robot is and what it does there,
        whereabouts: Reader<Whereabouts> => "map",
        /// and the floor around it.
        floor: Reader<FloorCheckpoint> => "adaptive",
    }
}

/// Scans, and the odometry of the time in which they were measured.
#[derive(Debug)]
pub struct ScanSymbols {
    /// The lidar's scans.
    pub scan: Reader<RangeScan>,
    /// Dead reckoning of the last third of a second.
    pub trace: Reader<OdometryTrace>,
}

/// Joins the structures of several users in one.
macro_rules! joined {
    ($(#[$meta:meta])* $name:ident, { $($(#[$field_meta:meta])* $field:ident: $symbols:ident,)* }) => {
        $(#[$meta])*
        #[derive(Debug)]
        pub struct $name { $($(#[$field_meta])* pub $field: $symbols,)* }

        impl $name {
            fn declare(builder: &mut TableBuilder) -> Result<(), SymbolError> {
                $($symbols::declare(builder)?;)*
                Ok(())
            }

            fn take(table: &SymbolTable) -> Result<Self, SymbolError> {
                Ok(Self { $($field: $symbols::take(table)?,)* })
            }
        }
    };
}

joined! {
    /// Of the chain of activities from encoders and scans to wheel setpoints.
    ChainSymbols, {
        /// Of the proprioception activity.
        proprioception: ProprioceptionSymbols,
        /// Of the navigation activity.
        navigation: NavigationSymbols,
        /// Of the same, on a managed site.
        navigation_fleet: NavigationFleetSymbols,
        /// Of the motion tube activity.
        motion_tube: MotionTubeSymbols,
        /// Of the control activity.
        control: ControlSymbols,
    }
}

joined! {
    /// Of all users.
    AllSymbols, {
        /// Of the drive activity.
        drive: DriveSymbols,
        /// Of the lidar activity.
        lidar: LidarSymbols,
        /// Of the activities between them.
        chain: ChainSymbols,
        /// Of the communication activity.
        communication: CommunicationSymbols,
        /// Of the same, on a managed site.
        communication_fleet: CommunicationFleetSymbols,
        /// Of the teleoperator's desk.
        teleop: TeleopSymbols,
        /// Of the supervisor.
        supervisor: SupervisorSymbols,
    }
}

/// All ends of all symbols.
pub struct Wiring {
    /// Keeps the shared memory.
    pub table: SymbolTable,
    /// Those of each user.
    pub symbols: AllSymbols,
    /// Scans, for each activity that looks at them.
    pub scans: Vec<(ActivityKind, ScanSymbols)>,
    /// Life cycles, in the order of [`ACTIVITIES`].
    pub states: Vec<Writer<ActivityState>>,
    /// Reports of the threads, in the order given: the thread's end and the supervisor's.
    pub threads: Vec<(Writer<ThreadReport>, Reader<ThreadReport>)>,
}

impl Wiring {
    fn declare(builder: &mut TableBuilder, threads: &[String]) -> Result<(), SymbolError> {
        AllSymbols::declare(builder)?;
        for activity in ACTIVITIES.map(ActivityKind::name) {
            builder.declare::<ActivityState>(activity, activity)?;
        }
        for thread in threads {
            builder.declare::<ThreadReport>(&owner_of(thread), thread)?;
        }
        Ok(())
    }

    fn take(table: SymbolTable, threads: &[String]) -> Result<Self, SymbolError> {
        let scans = |kind: ActivityKind| {
            let scan = table.reader(kind.name(), "hokuyo")?;
            let trace = table.reader(kind.name(), "odom")?;
            Ok((kind, ScanSymbols { scan, trace }))
        };
        let states = ACTIVITIES
            .iter()
            .map(|activity| table.writer(activity.name(), activity.name()))
            .collect::<Result<_, _>>()?;
        let reports = |thread: &String| {
            let writer = table.writer(&owner_of(thread), thread)?;
            Ok((writer, table.reader(SUPERVISOR, thread)?))
        };
        Ok(Self {
            symbols: AllSymbols::take(&table)?,
            scans: { SCAN_READERS.into_iter() }
                .map(scans)
                .collect::<Result<_, SymbolError>>()?,
            states,
            threads: { threads.iter() }
                .map(reports)
                .collect::<Result<_, SymbolError>>()?,
            table,
        })
    }

    /// Builds the symbol table of `robot_id` in `place` and takes every end of every symbol.
    ///
    /// # Errors
    /// [`SymbolError`], as when the robot runs already.
    pub fn build(
        robot_id: &str,
        place: &Namespace,
        threads: &[String],
    ) -> Result<Self, SymbolError> {
        let mut builder = TableBuilder::new(robot_id, place);
        Self::declare(&mut builder, threads)?;
        let wiring = Self::take(builder.build()?, threads)?;
        wiring.table.seal()?;
        Ok(wiring)
    }
}

/// A thread's report is owned by the thread, whatever activities run on it.
fn owner_of(thread: &str) -> String {
    format!("thread-{thread}")
}
