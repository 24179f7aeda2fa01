//! The faults this process knows: who notices, what happens, how it resumes.
//!
//! A fault is a level with a counter. Activities report edges through their queue; the supervisor owns the table.

use bytemuck::{Pod, Zeroable};
use serde::{Serialize, Serializer};

/// How a robot that stopped for a fault resumes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resumes {
    /// By itself, once the cause is gone.
    ByItself,
    /// After `onboard ctl reset`.
    Operator,
}

macro_rules! faults {
    ($($variant:ident = $number:literal, $name:literal, $resumes:ident, $sentence:literal;)*) => {
        /// A kind of fault.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
        #[serde(rename_all = "kebab-case")]
        #[repr(u8)]
        pub enum Fault {
            $(#[doc = $sentence] $variant = $number,)*
        }

        impl Fault {
            /// Every fault, in order of its number.
            pub const ALL: [Self; faults!(@count $($variant)*)] = [$(Self::$variant),*];

            /// Stable kebab-case name.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $name),* }
            }

            /// How the robot resumes.
            #[must_use]
            pub const fn resumes(self) -> Resumes {
                match self { $(Self::$variant => Resumes::$resumes),* }
            }

            /// What happened and what to do.
            #[must_use]
            pub const fn sentence(self) -> &'static str {
                match self { $(Self::$variant => $sentence),* }
            }
        }
    };
    (@count $($variant:ident)*) => { <[()]>::len(&[$(faults!(@unit $variant)),*]) };
    (@unit $variant:ident) => { () };
}

faults! {
    SetpointStale = 0, "setpoint-stale", ByItself,
        "the drive got no fresh wheel setpoint and ramps to a stop: the motion thread is late or has ended; see its overruns in `onboard inspect`";
    BusLost = 1, "bus-lost", ByItself,
        "the EtherCAT bus is lost: outputs are off and the bus is brought up again; check cable and power of the drive";
    BringUpLimit = 2, "bring-up-limit", Operator,
        "the bus had to be brought up too often in a minute, attempts in vain included; find the cause, then run `onboard ctl reset`";
    BusVoltage = 3, "bus-voltage", Operator,
        "the drive's bus voltage is outside its limits; charge or check the battery, then run `onboard ctl reset`";
    DriveFault = 4, "drive-fault", Operator,
        "the drive reports a motor fault; see its status in `onboard inspect`, then run `onboard ctl reset`";
    LidarLost = 5, "lidar-lost", ByItself,
        "the lidar is gone, reports an error, or sends its scans later and later or again and again, and is being reconnected; the log says which: check its cable, and what else runs on this computer";
    ScanSilent = 6, "scan-silent", ByItself,
        "no valid scan arrives: the robot stops, and drives on once scans have been good for a while; if it recurs, check the lidar";
    ScanBroken = 7, "scan-broken", ByItself,
        "a broken scan was dropped; if it recurs, check the lidar's cable and bit rate";
    NoFreeTube = 8, "no-free-tube", ByItself,
        "the way ahead is blocked: the robot waits until it has been free for a while; clear it if nothing moves, or say where the robot stands with `onboard ctl place` if it is elsewhere than `onboard inspect` says";
    PoseUncertain = 9, "pose-uncertain", Operator,
        "the pose is too uncertain to drive: the robot drives on when walls are in view again, unless a reset was refused before; if it does not, say where it stands with `onboard ctl place`";
    OffLane = 10, "off-lane", ByItself,
        "the robot is farther from its lane than the area allows: it comes back or stops, as the site's machine says; if it stops, run `onboard ctl reset`";
    CommandStale = 11, "command-stale", ByItself,
        "control got no fresh motion command and stops the robot: the navigation thread is late or has ended; see its overruns in `onboard inspect`";
    EncoderImplausible = 12, "encoder-implausible", ByItself,
        "an encoder reading was impossible and was left out; if it recurs, check the drive";
    Overruns = 13, "overruns", Operator,
        "a real-time thread overran in too many cycles and the robot stops; free the processor, then run `onboard ctl reset`";
    QueueFull = 14, "queue-full", ByItself,
        "an event was lost because its queue was full: the receiving activity is too slow; see overruns in `onboard inspect`";
    FleetNetwork = 15, "fleet-network", ByItself,
        "the fleet network cannot be reached; check `fleet` in the robot file and the network";
    OperatorStop = 16, "operator-stop", Operator,
        "stopped by an operator, or by a reset that was refused, or stopped already when its program began, whose log says by what; run `onboard ctl reset` to go on";
    Panic = 17, "panic", Operator,
        "a part of the program failed: the robot stops and the program ends; please report the message above it";
    MotorsOff = 18, "motors-off", Operator,
        "the drive does not power its motors, as when its emergency stop is pressed; release that, then run `onboard ctl reset`";
    MediatorSilent = 19, "mediator-silent", ByItself,
        "nothing is heard from the mediator, or it does not hear this robot: the robot stays in the areas in which it stands and stops before all others; check that the mediator runs, and the network";
    MediatorRefused = 20, "mediator-refused", ByItself,
        "the mediator refuses this robot; `fleet_state` in `onboard inspect` says why";
    PlaceUnknown = 21, "place-unknown", Operator,
        "after a restart, when its computer has slept, or when the robot was moved while nobody measured it, nobody knows where it is; say where it stands with `onboard ctl place`, then run `onboard ctl reset`";
    WheelSlip = 22, "wheel-slip", Operator,
        "the wheels turn farther than the robot moves, the log says which and how far, so it stops before it loses its place: look for what is slippery or blocks it, then run `onboard ctl reset`";
    IdentityDoubled = 23, "identity-doubled", ByItself,
        "another process reports with this robot's identity, and the mediator refuses it: end it, and give each robot an identity.id of its own; this robot goes on";
    DriveReturned = 24, "drive-returned", Operator,
        "the drive is back after it lost its power or was gone for over a second, as when an emergency stop takes its supply; look that the robot may drive; if somebody may have moved it meanwhile, say where it stands with `onboard ctl place`, and if it has to back out, how far the floor behind it is free with `onboard ctl free-behind`; then run `onboard ctl reset`";
    SecondMediator = 25, "second-mediator", ByItself,
        "a mediator speaks that is not the one this robot follows, and is ignored: end the one that is wrong, and restart robots that follow it";
    ThreadHung = 26, "thread-hung", Operator,
        "a thread of the program has not run for a second and the robot stops: see which in the log, free the processor or restart the program, then run `onboard ctl reset`";
    SupervisorSilent = 27, "supervisor-silent", ByItself,
        "the supervisor was not heard for a second, and the robot stopped: the process was starved or held up; see what else runs on this computer";
    WheelsDisobey = 28, "wheels-disobey", Operator,
        "a wheel does not do what it was told, the log says which and how far: look whether something blocks or pulls it, and at its motor and brakes; then run `onboard ctl reset`";
    LidarBlind = 29, "lidar-blind", ByItself,
        "the lidar sees nothing where the map has walls, so its scans do not count and the robot stops: uncover and clean its window; if the robot stands in the open, say where with `onboard ctl place`";
    OdometrySilent = 30, "odometry-silent", ByItself,
        "scans arrive, but nothing says how the robot moved meanwhile, so it stops: see what else is said of the bus, the drive and the motion thread; it drives on once scans have been good for a while";
    EncoderBroken = 31, "encoder-broken", Operator,
        "an encoder of a wheel or of the pivot moves otherwise than the speed that the drive reports for it, the log says which and how far: check the drive, then run `onboard ctl reset`";
    DriveStalled = 32, "drive-stalled", Operator,
        "the drive answers, but its sensors have stood still for 200 ms: switch it off and on, then run `onboard ctl reset`";
    FloorUnknown = 33, "floor-unknown", Operator,
        "the robot is to back out and knows nothing of the floor behind it, as after a restart, and it cannot see it: look behind it, say how far it is free with `onboard ctl free-behind`, then run `onboard ctl reset`";
    LidarFrozen = 34, "lidar-frozen", Operator,
        "the lidar has repeated its last scan three times within a minute, and shows what was there, not what is: switch it off and on, or replace it, then run `onboard ctl reset`";
    NoteUnwritten = 35, "note-unwritten", ByItself,
        "the note that the robot is under way is not on the disk, which is full, broken or takes too long, so that a computer that is switched off would forget it: the robot stands until it is; free the disk, or mend the folder of `--state`; the log says what is the matter";
}

/// Number of kinds.
pub const FAULTS: usize = Fault::ALL.len();

/// State of one kind of fault.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct FaultState {
    /// Monotonic time it was last raised, 0 for never.
    pub since_ns: u64,
    /// How often it was raised.
    pub count: u64,
    /// 1 while it lasts.
    pub active: u64,
}

/// State of every kind, indexed by its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct FaultTable {
    states: [FaultState; FAULTS],
}

impl Default for FaultTable {
    /// No fault, ever.
    fn default() -> Self {
        Self::zeroed()
    }
}

coordination::datatype!(FaultTable, "fault_table", description::SYMBOLS);

impl Serialize for FaultTable {
    /// Those that were ever raised, by name, and since when, on the monotonic clock.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Shown {
            active: bool,
            count: u64,
            since_ns: u64,
        }
        let raised = Fault::ALL
            .into_iter()
            .map(|fault| (fault, self.state(fault)))
            .filter(|(_, state)| state.count > 0);
        serializer.collect_map(raised.map(|(fault, state)| {
            let shown = Shown {
                active: state.active != 0,
                count: state.count,
                since_ns: state.since_ns,
            };
            (fault.name(), shown)
        }))
    }
}

impl FaultTable {
    /// Marks `fault` as present since `now_ns`. Returns whether that is news.
    pub fn raise(&mut self, fault: Fault, now_ns: u64) -> bool {
        let state = &mut self.states[fault as usize];
        let news = state.active == 0;
        state.count += 1;
        if news {
            *state = FaultState {
                since_ns: now_ns,
                active: 1,
                ..*state
            };
        }
        news
    }

    /// Marks `fault` as gone. Returns whether that is news.
    pub fn clear(&mut self, fault: Fault) -> bool {
        std::mem::take(&mut self.states[fault as usize].active) != 0
    }

    /// State of one kind.
    #[must_use]
    pub fn state(&self, fault: Fault) -> &FaultState {
        &self.states[fault as usize]
    }

    /// Kinds that are present.
    pub fn active(&self) -> impl Iterator<Item = Fault> + '_ {
        Fault::ALL
            .into_iter()
            .filter(|&fault| self.state(fault).active != 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_index_the_table_and_names_are_unique() {
        for (index, fault) in Fault::ALL.into_iter().enumerate() {
            assert_eq!(fault as usize, index);
            assert_eq!(
                Fault::ALL
                    .iter()
                    .filter(|other| other.name() == fault.name())
                    .count(),
                1
            );
        }
    }

    /// The README's table names each fault once, in its first column, and begins the last one with who ends it.
    #[test]
    fn the_readme_has_every_fault_and_how_it_resumes() {
        let readme = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../README.md"));
        let readme = readme.expect("readable");
        let (_, table) = readme.split_once("\n| fault | ").expect("a table");
        let rows = table
            .lines()
            .skip(2)
            .take_while(|line| line.starts_with('|'));
        let mut told: Vec<(String, &str)> = Vec::new();
        for row in rows {
            let cells: Vec<&str> = row.split('|').map(str::trim).collect();
            let [_, fault, _, resumes, _] = cells[..] else {
                panic!("not three columns: {row}");
            };
            // Its names come first, before a colon.
            let names = { fault.starts_with('`') }.then(|| fault.split_once(": "));
            for name in { names.flatten().into_iter() }.flat_map(|(names, _)| names.split(", ")) {
                told.push((name.trim_matches('`').to_owned(), resumes));
            }
        }
        for fault in Fault::ALL {
            let rows: Vec<&str> = { told.iter() }
                .filter(|(name, _)| name == fault.name())
                .map(|(_, resumes)| *resumes)
                .collect();
            let [resumes] = rows[..] else {
                panic!("{} has {} rows", fault.name(), rows.len());
            };
            let begins = match fault.resumes() {
                Resumes::ByItself => "by itself",
                Resumes::Operator => "operator: ",
            };
            assert!(resumes.starts_with(begins), "{}: {resumes}", fault.name());
        }
        assert_eq!(told.len(), FAULTS, "no others: {told:?}");
    }

    #[test]
    fn a_fault_is_a_level_with_a_counter() {
        let mut table = FaultTable::default();
        assert!(table.raise(Fault::ScanSilent, 5));
        assert!(!table.raise(Fault::ScanSilent, 9), "still the same one");
        assert_eq!(
            table.state(Fault::ScanSilent),
            &FaultState {
                since_ns: 5,
                count: 2,
                active: 1
            }
        );
        assert_eq!(table.active().collect::<Vec<_>>(), [Fault::ScanSilent]);
        assert!(table.clear(Fault::ScanSilent));
        assert!(!table.clear(Fault::ScanSilent));
        assert_eq!(table.state(Fault::ScanSilent).count, 2);
    }
}
