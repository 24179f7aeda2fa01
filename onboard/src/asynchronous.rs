//! The thread of the communication activity: the 5C loop on a tokio runtime with one worker.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread::{Builder, JoinHandle};
use std::time::Duration;

use coordination::activity::event_loop_once;
use tokio::time::{MissedTickBehavior, interval};

use crate::rt::clock::now_ns;
use crate::rt::scheduling::promote;
use crate::runner::{RobotActivity, ThreadSetup, Timing, Trigger};

/// Starts the thread. zenoh refuses tokio's current-thread scheduler, so there is one worker beside it.
///
/// # Errors
/// The operating system's.
pub fn spawn_asynchronous(
    setup: ThreadSetup,
    activities: Vec<Box<dyn RobotActivity>>,
) -> std::io::Result<JoinHandle<()>> {
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(1)
        .thread_name(format!("{}-tokio", setup.name))
        .enable_all()
        .build()?;
    Builder::new().name(setup.name.clone()).spawn(move || {
        for warning in promote(&setup.wanted) {
            setup.log.warn(format!("thread {}: {warning}", setup.name));
        }
        runtime.block_on(run(setup, activities));
        // A connection that hangs does not keep the robot's process alive.
        runtime.shutdown_timeout(Duration::from_secs(1));
    })
}

async fn run(mut setup: ThreadSetup, mut activities: Vec<Box<dyn RobotActivity>>) {
    let mut timing = Timing::new(&setup.trigger);
    let period = match setup.trigger {
        Trigger::Period(period_ns) => Duration::from_nanos(period_ns),
        Trigger::Device | Trigger::Wake(..) => Duration::from_millis(50),
    };
    let mut ticks = interval(period);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
    let stop = Arc::clone(&setup.stop);
    while !stop.load(Ordering::Relaxed) {
        let planned = ticks.tick().await;
        let late_ns = u64::try_from(planned.elapsed().as_nanos()).unwrap_or(u64::MAX);
        let begin_ns = now_ns();
        timing.woken(begin_ns.saturating_sub(late_ns), late_ns);
        for activity in &mut activities {
            event_loop_once(activity.as_mut(), now_ns());
        }
        timing.executed(begin_ns, 0, true);
        timing.publish(&mut setup.report);
    }
    timing.publish_now(&mut setup.report);
}
