//! Communication: publishes the robot's state on the fleet's network as `contract` defines.
//!
//! The only activity with an asynchronous side: its thread drives a tokio runtime with one worker, as zenoh wants it.

use std::time::Duration;

use contract::wire::{Fault as FaultMessage, Pose, RobotState};
use contract::{Message, keys};
use coordination::activity::{Activity, LifeCycle, LifeCycleEvent, LifeCycleState};
use coordination::symbols::{Reader, Stamped};
use zenoh::Wait;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::Publisher;
use zenoh::qos::CongestionControl;

use crate::faults::{Fault, FaultTable};
use crate::log::{Complaints, LogSender};
use crate::port::Port;
use crate::rt::clock::{MILLISECOND_NS, SECOND_NS};
use crate::runner::RobotActivity;
use crate::supervisor::Mode;
use crate::values::{NavigationState, OdometryValue, PoseEstimate, RobotMode};

/// Period of the event loop: a change is published within it.
pub const PERIOD: Duration = Duration::from_millis(50);
/// A level is sent at least this often.
const LEVEL_NS: u64 = 200 * MILLISECOND_NS;
/// Pause between two attempts to open the network.
const RETRY_NS: u64 = SECOND_NS;

/// What the communication activity needs to know.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Robot, as its file names it.
    pub robot_id: String,
    /// Role that the site gives it.
    pub role: String,
    /// Drawn at start.
    pub boot_epoch: u64,
    /// Prefix of all keys.
    pub key_prefix: String,
    /// Endpoints to listen on.
    pub listen: Vec<String>,
    /// Endpoints to connect to.
    pub connect: Vec<String>,
    /// Whether peers are looked for by multicast.
    pub scouting: bool,
    /// Interface for multicast.
    pub interface: Option<String>,
}

/// The symbols it reads.
#[derive(Debug)]
pub struct Symbols {
    /// Pose in `map`.
    pub pose: Reader<PoseEstimate>,
    /// Speeds.
    pub odometry: Reader<OdometryValue>,
    /// State, area and skill.
    pub navigation: Reader<NavigationState>,
    /// Faults of the whole robot.
    pub faults: Reader<FaultTable>,
    /// What the robot is doing.
    pub mode: Reader<RobotMode>,
}

/// What was read in one event loop.
#[derive(Clone, Copy, Debug, Default)]
struct Snapshot {
    pose: Stamped<PoseEstimate>,
    odometry: OdometryValue,
    navigation: NavigationState,
    faults: FaultTable,
    mode: u64,
}

/// An open network; closes when it is dropped.
struct Network {
    publisher: Publisher<'static>,
    _alive: LivelinessToken,
    // Last, so that what was declared on it goes first.
    session: zenoh::Session,
}

/// The activity.
pub struct Communication {
    port: Port,
    settings: Settings,
    symbols: Symbols,
    log: LogSender,
    network: Option<Network>,
    snapshot: Snapshot,
    sequence: u64,
    sent: Option<RobotState>,
    sent_ns: u64,
    retry_ns: u64,
    complaints: Complaints,
}

impl Communication {
    /// An activity in state *created*.
    #[must_use]
    pub fn new(port: Port, settings: Settings, symbols: Symbols, log: LogSender) -> Self {
        Self {
            port,
            settings,
            symbols,
            log,
            network: None,
            snapshot: Snapshot::default(),
            sequence: 0,
            sent: None,
            sent_ns: 0,
            retry_ns: 0,
            complaints: Complaints::default(),
        }
    }

    fn open(&self) -> Result<Network, String> {
        let Settings {
            robot_id,
            key_prefix,
            ..
        } = &self.settings;
        let state_key = keys::state(key_prefix, robot_id).map_err(|error| error.to_string())?;
        let alive_key = keys::alive(key_prefix, robot_id).map_err(|error| error.to_string())?;
        let text = |error: zenoh::Error| error.to_string();
        let session = zenoh::open(zenoh_config(&self.settings)?)
            .wait()
            .map_err(text)?;
        let publisher = session
            .declare_publisher(state_key)
            .congestion_control(CongestionControl::Drop)
            .express(true)
            .wait()
            .map_err(text)?;
        let alive = session
            .liveliness()
            .declare_token(alive_key)
            .wait()
            .map_err(text)?;
        Ok(Network {
            publisher,
            _alive: alive,
            session,
        })
    }

    /// One attempt to open the network. Called once before any thread is promoted, so that zenoh's threads inherit no
    /// real-time priority, and again after failures.
    pub fn open_network(&mut self, now_ns: u64) {
        self.retry_ns = now_ns + RETRY_NS;
        match self.open() {
            Ok(network) => {
                self.log.info(format!(
                    "fleet network is open, session {}",
                    network.session.zid()
                ));
                self.network = Some(network);
                self.complaints.forget();
                self.port.clear(Fault::FleetNetwork);
            }
            Err(complaint) => {
                self.complaints
                    .say(&self.log, "fleet network cannot be opened", complaint);
                self.port.raise(Fault::FleetNetwork, 0.0);
            }
        }
    }

    fn retry_network(&mut self, now_ns: u64) {
        if self.network.is_none() && now_ns >= self.retry_ns {
            self.port.step(LifeCycleEvent::Fault); // back to configuring, for the next attempt
        }
    }

    fn state_message(&self) -> RobotState {
        let Snapshot {
            pose,
            odometry,
            navigation,
            faults,
            mode,
        } = &self.snapshot;
        RobotState {
            robot_id: self.settings.robot_id.clone(),
            boot_epoch: self.settings.boot_epoch,
            sequence: 0,
            stamp_ns: pose.stamp_ns,
            pose: (pose.stamp_ns != 0).then_some(Pose {
                x_m: pose.value.x_m,
                y_m: pose.value.y_m,
                theta_rad: pose.value.theta_rad,
                std_x_m: pose.value.std_x_m,
                std_y_m: pose.value.std_y_m,
                std_theta_rad: pose.value.std_theta_rad,
            }),
            speed_m_s: odometry.v_m_s,
            yaw_rate_rad_s: odometry.omega_rad_s,
            fsm_state: navigation.state.as_str().to_owned(),
            area: navigation.area.as_str().to_owned(),
            skill: navigation.skill.as_str().to_owned(),
            role: self.settings.role.clone(),
            mode: Mode::name_of(*mode).to_owned(),
            faults: fault_messages(faults),
            laps: u32::try_from(navigation.laps).unwrap_or(u32::MAX),
        }
    }

    fn publish_state(&mut self, now_ns: u64) {
        let Some(network) = &self.network else { return };
        let mut state = self.state_message();
        let changed = self.sent.as_ref().is_none_or(|sent| is_news(sent, &state));
        if !changed && now_ns < self.sent_ns + LEVEL_NS {
            return;
        }
        self.sequence += 1;
        state.sequence = self.sequence;
        state
            .faults
            .iter_mut()
            .for_each(|fault| fault.age_ms = age_ms(&self.snapshot.faults, &fault.name, now_ns));
        match network.publisher.put(state.encode_to_vec()).wait() {
            Ok(()) => self.port.clear(Fault::FleetNetwork),
            Err(error) => {
                self.log
                    .warn(format!("the state could not be published: {error}"));
                self.port.raise(Fault::FleetNetwork, 0.0);
            }
        }
        self.sent = Some(state);
        self.sent_ns = now_ns;
    }
}

impl Activity for Communication {
    fn name(&self) -> &'static str {
        "communication"
    }

    fn life_cycle(&self) -> &LifeCycle {
        self.port.life_cycle()
    }

    fn communicate_in(&mut self, _now_ns: u64) {
        self.snapshot = Snapshot {
            pose: self.symbols.pose.read(),
            odometry: self.symbols.odometry.read().value,
            navigation: self.symbols.navigation.read().value,
            faults: self.symbols.faults.read().value,
            mode: self.symbols.mode.read().value.mode,
        };
    }

    fn coordinate(&mut self, _now_ns: u64) {
        while self.port.next_command().is_some() {} // none but the life cycle's concerns it
    }

    fn configure(&mut self, now_ns: u64) {
        if self.network.is_none() {
            if now_ns < self.retry_ns {
                return;
            }
            self.open_network(now_ns);
        }
        // A robot without its fleet still drives where nothing needs granting.
        self.port.step(LifeCycleEvent::Configured);
    }

    fn compute(&mut self, now_ns: u64) {
        self.retry_network(now_ns);
    }

    fn rest(&mut self, now_ns: u64) {
        if self.port.state() == LifeCycleState::Ready {
            self.retry_network(now_ns);
        }
    }

    fn communicate_out(&mut self, now_ns: u64) {
        self.publish_state(now_ns);
        if self.port.state() == LifeCycleState::Stopped {
            self.network = None;
        }
        self.port.publish(now_ns);
    }
}

impl RobotActivity for Communication {}

/// Faults that were ever raised.
fn fault_messages(table: &FaultTable) -> Vec<FaultMessage> {
    Fault::ALL
        .into_iter()
        .map(|fault| (fault, table.state(fault)))
        .filter(|(_, state)| state.count > 0)
        .map(|(fault, state)| FaultMessage {
            name: fault.name().to_owned(),
            active: state.active != 0,
            count: state.count,
            age_ms: 0,
        })
        .collect()
}

fn age_ms(table: &FaultTable, name: &str, now_ns: u64) -> u64 {
    let since_ns = Fault::ALL
        .into_iter()
        .find(|fault| fault.name() == name)
        .map(|fault| table.state(fault).since_ns);
    now_ns.saturating_sub(since_ns.unwrap_or(now_ns)) / MILLISECOND_NS
}

/// Whether what is discrete in the state has changed; pose and speed go with the 5 Hz level.
fn is_news(sent: &RobotState, state: &RobotState) -> bool {
    let ages_aside = |faults: &[FaultMessage]| {
        faults
            .iter()
            .map(|fault| (fault.name.clone(), fault.active, fault.count))
            .collect::<Vec<_>>()
    };
    sent.fsm_state != state.fsm_state
        || sent.area != state.area
        || sent.skill != state.skill
        || sent.mode != state.mode
        || sent.laps != state.laps
        || ages_aside(&sent.faults) != ages_aside(&state.faults)
}

fn zenoh_config(settings: &Settings) -> Result<zenoh::Config, String> {
    let mut config = zenoh::Config::default();
    let mut set = |key: &str, value: serde_json::Value| {
        config
            .insert_json5(key, &value.to_string())
            .map_err(|error| format!("fleet network setting {key} = {value} is refused: {error}"))
    };
    set("mode", "peer".into())?;
    set("listen/endpoints", settings.listen.clone().into())?;
    set("connect/endpoints", settings.connect.clone().into())?;
    // A peer that is not there yet is connected to when it comes; the robot does not wait for it.
    set("connect/timeout_ms", 0.into())?;
    set("connect/exit_on_failure", false.into())?;
    set("scouting/multicast/enabled", settings.scouting.into())?;
    set("scouting/gossip/enabled", settings.scouting.into())?;
    if let Some(interface) = &settings.interface {
        set("scouting/multicast/interface", interface.clone().into())?;
    }
    Ok(config)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_discrete_changes_are_news() {
        let state = RobotState {
            area: "1".into(),
            speed_m_s: 0.1,
            ..RobotState::default()
        };
        assert!(!is_news(
            &state,
            &RobotState {
                speed_m_s: 0.4,
                ..state.clone()
            }
        ));
        assert!(is_news(
            &state,
            &RobotState {
                area: "2".into(),
                ..state.clone()
            }
        ));
    }

    #[test]
    fn a_bad_endpoint_is_named() {
        let settings = Settings {
            robot_id: "amr-1".into(),
            role: "normal".into(),
            boot_epoch: 1,
            key_prefix: "test".into(),
            listen: vec!["nonsense".into()],
            connect: Vec::new(),
            scouting: false,
            interface: None,
        };
        let error = zenoh_config(&settings).expect_err("refused");
        assert!(
            error.contains("listen/endpoints") && error.contains("nonsense"),
            "{error}"
        );
    }
}
