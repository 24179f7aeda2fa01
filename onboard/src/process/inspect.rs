//! `onboard inspect`: every symbol and every thread of a running robot, seen from another process.

use std::collections::BTreeSet;
use std::io::{IsTerminal, Write};
use std::time::Duration;

use coordination::activity::LifeCycleState;
use coordination::symbols::{Datatype, Inspector, SymbolError, SymbolInfo};
use serde::Serialize;
use serde_json::{Value as Json, json};
use skills::borders::AreaSet;
use skills::odometry::Odometry;
use skills::tubes::FloorCheckpoint;

use crate::composition::failure::Failure;
use crate::process::runtime::Runtime;
use crate::realtime::clock::now_ns;
use crate::realtime::memory::page_faults_of;
use crate::symbols::faults::FaultTable;
use crate::symbols::values::{
    ActivityState, DriveStatus, Encoders, FleetState, LidarStatus, Load, NavigationState,
    OdometryTrace, PoseEstimate, RangeScan, RobotMode, SafeCommand, TeleopWish, ThreadReport,
    TubeState, WantedMotion, WheelSetpoints, Whereabouts,
};

const WATCH_PERIOD: Duration = Duration::from_secs(1);
/// Longest value in the table for people; `--json` has all of it.
const SHOWN_CHARACTERS: usize = 110;

/// One symbol with its value.
#[derive(Debug)]
struct Seen {
    info: SymbolInfo,
    age_ms: Option<f64>,
    value: Json,
}

/// Lists a running robot, or what of it has this name: a symbol's datatype or model, both (`load/robot`), or a thread.
///
/// # Errors
/// [`Failure::Refused`] when there is no such robot, or nothing of this name, [`Failure::Failed`] when it ends while watched.
pub fn inspect(
    runtime: &Runtime,
    (robot, name): (Option<&str>, Option<&str>),
    watch: bool,
    as_json: bool,
) -> Result<(), Failure> {
    let robot = runtime.choose(robot)?;
    let inspector = Inspector::open(&robot, &runtime.place()).map_err(|error| {
        Failure::refused(format_args!("robot `{robot}` cannot be inspected: {error}"))
    })?;
    loop {
        let mut seen = look(&inspector).map_err(Failure::failed)?;
        if let Some(name) = name {
            seen = only(seen, name)?;
        }
        let text = if as_json {
            format!("{}\n", as_json_object(&robot, &seen))
        } else {
            let shown = name.map_or(SHOWN_CHARACTERS, |_| usize::MAX);
            table(&robot, &seen, shown)
        };
        let mut out = std::io::stdout().lock();
        if watch && !as_json && out.is_terminal() {
            let _ = write!(out, "\x1b[2J\x1b[H");
        }
        if out
            .write_all(text.as_bytes())
            .and_then(|()| out.flush())
            .is_err()
            || !watch
        {
            return Ok(()); // the reader of a pipe has left, or once was enough
        }
        drop(out);
        std::thread::sleep(WATCH_PERIOD);
        if !inspector.is_alive() {
            return Err(Failure::failed(format_args!("robot `{robot}` has ended")));
        }
    }
}

/// The same as `--json` prints, for programs.
///
/// # Errors
/// [`Failure::Refused`] when there is no such robot.
pub fn snapshot(runtime: &Runtime, robot: &str) -> Result<Json, Failure> {
    let inspector = Inspector::open(robot, &runtime.place()).map_err(Failure::refused)?;
    Ok(as_json_object(
        robot,
        &look(&inspector).map_err(Failure::failed)?,
    ))
}

/// What has this name.
fn only(seen: Vec<Seen>, name: &str) -> Result<Vec<Seen>, Failure> {
    let full = |info: &SymbolInfo| format!("{}/{}", info.datatype, info.model);
    let (named, others): (Vec<Seen>, Vec<Seen>) = { seen.into_iter() }.partition(|seen| {
        let info = &seen.info;
        [&info.datatype, &info.model, &full(info)].contains(&&name.to_owned())
    });
    if named.is_empty() {
        let known: Vec<String> = others.iter().map(|seen| full(&seen.info)).collect();
        return Err(Failure::refused(format_args!(
            "nothing is called `{name}`; there are {}",
            known.join(", ")
        )));
    }
    Ok(named)
}

fn look(inspector: &Inspector) -> Result<Vec<Seen>, SymbolError> {
    let seen = inspector.directory().into_iter();
    seen.map(|info| see(inspector, info))
        // Symbols that were added can be removed in between.
        .filter(|seen| !matches!(seen, Err(SymbolError::Unknown { .. })))
        .collect()
}

fn see(inspector: &Inspector, info: SymbolInfo) -> Result<Seen, SymbolError> {
    macro_rules! by_datatype {
        ($($datatype:ident),* $(,)?) => {
            match info.datatype.as_str() {
                $(name if name == <$datatype as Datatype>::NAME => read::<$datatype>(inspector, info),)*
                // A newer program may have symbols that this one does not know.
                _ => Ok(Seen { info, age_ms: None, value: Json::Null }),
            }
        };
    }
    by_datatype!(
        ActivityState,
        AreaSet,
        DriveStatus,
        Encoders,
        FaultTable,
        FleetState,
        FloorCheckpoint,
        LidarStatus,
        Load,
        NavigationState,
        OdometryTrace,
        Odometry,
        PoseEstimate,
        RangeScan,
        RobotMode,
        SafeCommand,
        TeleopWish,
        ThreadReport,
        TubeState,
        WantedMotion,
        WheelSetpoints,
        Whereabouts,
    )
}

fn read<T: Datatype + Serialize>(
    inspector: &Inspector,
    info: SymbolInfo,
) -> Result<Seen, SymbolError> {
    let read = inspector.reader::<T>(&info.model)?.read();
    let age_ms = read.age_ns(now_ns()).map(|age_ns| age_ns as f64 / 1e6);
    let mut value = serde_json::to_value(read.value).unwrap_or_default();
    if T::NAME == ThreadReport::NAME {
        value["page_faults"] = json!(page_faults_while_running(&value));
    }
    Ok(Seen {
        info,
        age_ms,
        value,
    })
}

/// Page faults of a thread since it drives the robot; the kernel counts them, so that the thread need not ask it.
fn page_faults_while_running(report: &Json) -> Option<u64> {
    let number = |key: &str| report[key].as_u64();
    number("running").filter(|&running| running != 0)?;
    let faults = page_faults_of(number("thread")?)?;
    Some(faults.saturating_sub(number("faults_before")?))
}

fn as_json_object(robot: &str, seen: &[Seen]) -> Json {
    let symbols: Vec<Json> = seen
        .iter()
        .map(|seen| {
            json!({ "id": seen.info.semantic_id().to_string(), "datatype": seen.info.datatype, "model": seen.info.model, "metamodel": seen.info.metamodel,
                "added": seen.info.is_added, "owner": seen.info.owner, "readers": seen.info.readers, "size_bytes": seen.info.size_bytes, "age_ms": seen.age_ms,
                "value": seen.value })
        })
        .collect();
    json!({ "robot": robot, "symbols": symbols })
}

/// For people; of each value at most so many characters.
fn table(robot: &str, seen: &[Seen], characters: usize) -> String {
    let (threads, symbols): (Vec<&Seen>, Vec<&Seen>) = seen
        .iter()
        .partition(|seen| seen.info.datatype == ThreadReport::NAME);
    let metamodels: BTreeSet<&str> = { seen.iter() }
        .map(|seen| seen.info.metamodel.as_str())
        .collect();
    let metamodels: Vec<&str> = metamodels.into_iter().collect();
    let mut text = format!(
        "robot {robot}; symbols conform to {}\n\n{:<34} {:<15} {:>9}  {}\n",
        metamodels.join(", "),
        "symbol (datatype/model)",
        "owner",
        "age ms",
        "value; readers"
    );
    for seen in symbols {
        let age = seen
            .age_ms
            .map_or("never".to_owned(), |age_ms| format!("{age_ms:.1}"));
        text += &format!(
            "{:<34} {:<15} {age:>9}  {}; {}{}\n",
            format!("{}/{}", seen.info.datatype, seen.info.model),
            seen.info.owner,
            shown(seen, characters),
            if seen.info.readers.is_empty() {
                "-".to_owned()
            } else {
                seen.info.readers.join(" ")
            },
            if seen.info.is_added { "; added" } else { "" }
        );
    }
    if threads.is_empty() {
        return text;
    }
    text += &format!(
        "\n{:<14} {:<9} {:<8} {:>9} {:>9} {:>9} {:>11} {:>26} {:>26}\n",
        "thread",
        "policy",
        "cores",
        "cycles",
        "overruns",
        "missed",
        "page faults",
        "wake-up µs p50/p99/max",
        "execution µs p50/p99/max"
    );
    for seen in threads {
        let value = &seen.value;
        let times = |name: &str| {
            let of = |part: &str| value[name][part].as_f64().unwrap_or(0.0);
            // A thread that waits on its device has no time at which it should have woken.
            let unplanned = name == "wakeup" && value["period_ns"] == 0;
            if unplanned {
                "-".to_owned()
            } else {
                format!("{:.0}/{:.0}/{:.0}", of("p50"), of("p99"), of("max"))
            }
        };
        text += &format!(
            "{:<14} {:<9} {:<8} {:>9} {:>9} {:>9} {:>11} {:>26} {:>26}\n",
            seen.info.model,
            format!(
                "{} {}",
                value["granted"]["policy"].as_str().unwrap_or("?"),
                value["granted"]["priority"]
            ),
            value["granted"]["cores"].as_str().unwrap_or("?"),
            value["cycles"],
            value["overruns"],
            value["missed"],
            plain(&value["page_faults"]),
            times("wakeup"),
            times("exec")
        );
    }
    text
}

/// The value on one line, without the bulk of scans.
fn shown(seen: &Seen, characters: usize) -> String {
    let mut value = seen.value.clone();
    if let Some(ranges) = value.get_mut("ranges_mm") {
        *ranges = json!("(see --json)");
    }
    if seen.info.datatype == ActivityState::NAME {
        let state = value["state"]
            .as_u64()
            .and_then(|number| u8::try_from(number).ok());
        value["state"] = json!(
            state
                .and_then(LifeCycleState::from_u8)
                .map_or("?", LifeCycleState::name)
        );
    }
    let fields = value.as_object().map(|object| {
        object
            .iter()
            .map(|(key, value)| format!("{key}={}", plain(value)))
            .collect::<Vec<_>>()
            .join(" ")
    });
    let text = fields.unwrap_or_else(|| value.to_string());
    // What a robot waits for is told in whole sentences.
    let shown = if seen.info.datatype == FleetState::NAME {
        usize::MAX
    } else {
        characters
    };
    match text.char_indices().nth(shown) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

fn plain(value: &Json) -> String {
    match value {
        Json::Number(number) if number.is_f64() => format!("{:.3}", number.as_f64().unwrap_or(0.0)),
        Json::String(text) => text.clone(),
        Json::Null => "-".to_owned(),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::process::runtime::temporary;
    use crate::symbols::wiring::Wiring;

    #[test]
    fn every_symbol_of_a_robot_is_shown_and_found_by_its_names() {
        let folder = temporary();
        let runtime =
            Runtime::new(Some(folder.path().to_owned())).unwrap_or_else(|_| unreachable!());
        let place = runtime.place();
        let _wiring = Wiring::build("seen", &place, &["motion".to_owned()]).expect("symbols");
        let inspector = Inspector::open("seen", &place).expect("it is there");
        for seen in look(&inspector).expect("readable") {
            assert_ne!(seen.value, Json::Null, "{:?}", seen.info);
        }
        let named = |name: &str| {
            let found = only(look(&inspector).expect("readable"), name).ok()?;
            Some(
                found
                    .iter()
                    .map(|seen| seen.info.datatype.clone())
                    .collect(),
            )
        };
        for (name, found) in [
            ("load", Some(vec!["load".to_owned()])),
            ("load/robot", Some(vec!["load".to_owned()])),
            ("motion", Some(vec!["thread_report".to_owned()])),
            ("pose", None),
        ] {
            assert_eq!(named(name), found, "{name}");
        }
    }
}
