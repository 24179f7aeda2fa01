//! The wiring: which symbols there are, who owns each, who reads it. One place, for `run` and `check`.

use coordination::symbols::{
    Datatype, Place, Reader, SymbolError, SymbolTable, TableBuilder, Writer,
};

use crate::activities::{
    communication, control, drive, lidar, motion_tube, navigation, proprioception,
};
use crate::process::supervisor;
use crate::realtime::wake::Wake;
use crate::symbols::faults::FaultTable;
use crate::symbols::values::{
    ActivityState, AllowedAreas, CommandValue, DriveStatus, Encoders, FleetState, LidarStatus,
    NavigationState, OdometryTrace, OdometryValue, PoseEstimate, RangeScan, RobotMode,
    ThreadReport, TubeState, WantedMotion, WheelSetpointsValue, Whereabouts,
};

// Names in the table: activities as the robot file calls them, and models.
const DRIVE: &str = "drive";
const PROPRIOCEPTION: &str = "proprioception";
const LIDAR: &str = "lidar";
const NAVIGATION: &str = "navigation";
const MOTION_TUBE: &str = "motion-tube";
const CONTROL: &str = "control";
const COMMUNICATION: &str = "communication";
const SUPERVISOR: &str = "supervisor";

const KELO: &str = "kelo";
const ODOM: &str = "odom";
const HOKUYO: &str = "hokuyo";
const MAP: &str = "map";
const ROBOT: &str = "robot";
const ADAPTIVE: &str = "adaptive";
const WANTED: &str = "wanted";
const SAFE: &str = "safe";
const FLEET: &str = "fleet";

/// Activities, in the order in which data flows.
pub const ACTIVITIES: [&str; 7] = [
    DRIVE,
    PROPRIOCEPTION,
    LIDAR,
    NAVIGATION,
    MOTION_TUBE,
    CONTROL,
    COMMUNICATION,
];

/// All ends of all symbols.
pub struct Wiring {
    /// Keeps the shared memory.
    pub table: SymbolTable,
    /// Of the drive activity.
    pub drive: drive::Symbols,
    /// Of the proprioception activity.
    pub proprioception: proprioception::Symbols,
    /// Of the control activity.
    pub control: control::Symbols,
    /// Of the lidar activity.
    pub lidar: lidar::Symbols,
    /// Of the navigation activity.
    pub navigation: navigation::Symbols,
    /// Of the same, on a managed site.
    pub navigation_fleet: navigation::FleetSymbols,
    /// Of the motion tube activity.
    pub motion_tube: motion_tube::Symbols,
    /// Of the communication activity.
    pub communication: communication::Symbols,
    /// Of the same, on a managed site.
    pub communication_fleet: communication::FleetSymbols,
    /// Of the supervisor.
    pub supervisor: supervisor::Symbols,
    /// Life cycles, in the order of [`ACTIVITIES`].
    pub states: Vec<Writer<ActivityState>>,
    /// Reports of the threads, in the order given: the thread's end and the supervisor's.
    pub threads: Vec<(Writer<ThreadReport>, Reader<ThreadReport>)>,
    /// Wakes the thread that waits for scans.
    pub scan_wake: Wake,
}

impl Wiring {
    /// Builds the symbol table of `robot_id` in `place` and takes every end of every symbol.
    ///
    /// # Errors
    /// [`SymbolError`], as when the robot runs already.
    pub fn build(robot_id: &str, place: &Place, threads: &[String]) -> Result<Self, SymbolError> {
        let mut builder = TableBuilder::new(robot_id, place);
        declare(&mut builder, threads)?;
        let table = builder.build()?;
        let wiring = Self::connect(table, threads)?;
        wiring.table.seal()?;
        Ok(wiring)
    }

    fn connect(table: SymbolTable, threads: &[String]) -> Result<Self, SymbolError> {
        let scan_wake = Wake::default();
        Ok(Self {
            drive: drive::Symbols {
                setpoints: table.reader(DRIVE, KELO)?,
                encoders: table.writer(DRIVE, KELO)?,
                status: table.writer(DRIVE, KELO)?,
            },
            proprioception: proprioception::Symbols {
                encoders: table.reader(PROPRIOCEPTION, KELO)?,
                odometry: table.writer(PROPRIOCEPTION, ODOM)?,
                trace: table.writer(PROPRIOCEPTION, ODOM)?,
            },
            lidar: lidar::Symbols {
                scan: table.writer(LIDAR, HOKUYO)?,
                status: table.writer(LIDAR, HOKUYO)?,
                wake: scan_wake.clone(),
            },
            navigation: navigation::Symbols {
                scan: table.reader(NAVIGATION, HOKUYO)?,
                odometry: table.reader(NAVIGATION, ODOM)?,
                trace: table.reader(NAVIGATION, ODOM)?,
                command: table.writer(NAVIGATION, WANTED)?,
                pose: table.writer(NAVIGATION, MAP)?,
                state: table.writer(NAVIGATION, ROBOT)?,
            },
            navigation_fleet: navigation::FleetSymbols {
                allowed: table.reader(NAVIGATION, FLEET)?,
                whereabouts: table.writer(NAVIGATION, FLEET)?,
            },
            motion_tube: motion_tube::Symbols {
                scan: table.reader(MOTION_TUBE, HOKUYO)?,
                odometry: table.reader(MOTION_TUBE, ODOM)?,
                trace: table.reader(MOTION_TUBE, ODOM)?,
                wanted: table.reader(MOTION_TUBE, WANTED)?,
                safe: table.writer(MOTION_TUBE, SAFE)?,
                state: table.writer(MOTION_TUBE, ADAPTIVE)?,
            },
            control: control::Symbols {
                command: table.reader(CONTROL, SAFE)?,
                encoders: table.reader(CONTROL, KELO)?,
                drive: table.reader(CONTROL, KELO)?,
                setpoints: table.writer(CONTROL, KELO)?,
            },
            communication: communication::Symbols {
                pose: table.reader(COMMUNICATION, MAP)?,
                odometry: table.reader(COMMUNICATION, ODOM)?,
                navigation: table.reader(COMMUNICATION, ROBOT)?,
                faults: table.reader(COMMUNICATION, ROBOT)?,
                mode: table.reader(COMMUNICATION, ROBOT)?,
            },
            communication_fleet: communication::FleetSymbols {
                whereabouts: table.reader(COMMUNICATION, FLEET)?,
                allowed: table.writer(COMMUNICATION, FLEET)?,
                state: table.writer(COMMUNICATION, FLEET)?,
            },
            supervisor: supervisor::Symbols {
                faults: table.writer(SUPERVISOR, ROBOT)?,
                mode: table.writer(SUPERVISOR, ROBOT)?,
                encoders: table.reader(SUPERVISOR, KELO)?,
                drive: table.reader(SUPERVISOR, KELO)?,
            },
            states: ACTIVITIES
                .iter()
                .map(|activity| table.writer(activity, activity))
                .collect::<Result<_, _>>()?,
            threads: threads
                .iter()
                .map(|thread| {
                    Ok((
                        table.writer(&owner_of(thread), thread)?,
                        table.reader(SUPERVISOR, thread)?,
                    ))
                })
                .collect::<Result<_, SymbolError>>()?,
            scan_wake,
            table,
        })
    }
}

fn declare(builder: &mut TableBuilder, threads: &[String]) -> Result<(), SymbolError> {
    fn one<T: Datatype>(
        builder: &mut TableBuilder,
        owner: &str,
        model: &str,
    ) -> Result<(), SymbolError> {
        builder.declare::<T>(owner, model).map(|_| ())
    }
    one::<Encoders>(builder, DRIVE, KELO)?;
    one::<DriveStatus>(builder, DRIVE, KELO)?;
    one::<OdometryValue>(builder, PROPRIOCEPTION, ODOM)?;
    one::<OdometryTrace>(builder, PROPRIOCEPTION, ODOM)?;
    one::<RangeScan>(builder, LIDAR, HOKUYO)?;
    one::<LidarStatus>(builder, LIDAR, HOKUYO)?;
    one::<PoseEstimate>(builder, NAVIGATION, MAP)?;
    one::<NavigationState>(builder, NAVIGATION, ROBOT)?;
    one::<Whereabouts>(builder, NAVIGATION, FLEET)?;
    one::<AllowedAreas>(builder, COMMUNICATION, FLEET)?;
    one::<FleetState>(builder, COMMUNICATION, FLEET)?;
    one::<WantedMotion>(builder, NAVIGATION, WANTED)?;
    one::<CommandValue>(builder, MOTION_TUBE, SAFE)?;
    one::<TubeState>(builder, MOTION_TUBE, ADAPTIVE)?;
    one::<WheelSetpointsValue>(builder, CONTROL, KELO)?;
    one::<FaultTable>(builder, SUPERVISOR, ROBOT)?;
    one::<RobotMode>(builder, SUPERVISOR, ROBOT)?;
    for activity in ACTIVITIES {
        one::<ActivityState>(builder, activity, activity)?;
    }
    for thread in threads {
        one::<ThreadReport>(builder, &owner_of(thread), thread)?;
    }
    Ok(())
}

/// A thread's report is owned by the thread, whatever activities run on it.
fn owner_of(thread: &str) -> String {
    format!("thread-{thread}")
}
