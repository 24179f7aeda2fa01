//! The whole example, as fast as threads can.

use std::time::Duration;

#[allow(dead_code, reason = "its main function is for the example")]
#[path = "../../examples/t_junction.rs"]
mod example;

use example::{Outcome, Settings, run};

#[test]
fn three_robots_cross_hundreds_of_times_one_at_a_time() {
    let crossings = 2_000;
    let outcome = run(Settings {
        crossings,
        drive: Duration::ZERO,
        patience: Duration::from_secs(120),
        print: false,
    });
    let expected = Outcome {
        crossings: 3 * crossings,
        most_inside: 1,
        firings: 9 * u64::from(crossings),
    };
    assert_eq!(outcome.unwrap(), expected);
}

#[test]
fn a_junction_comes_and_goes() {
    for _ in 0..100 {
        let outcome = run(Settings {
            crossings: 3,
            drive: Duration::ZERO,
            patience: Duration::from_secs(60),
            print: false,
        });
        assert_eq!(outcome.unwrap().most_inside, 1);
    }
}

#[test]
fn impatience_ends_it_with_a_reason() {
    let outcome = run(Settings {
        crossings: u32::MAX,
        drive: Duration::ZERO,
        patience: Duration::from_millis(20),
        print: false,
    });
    let error = outcome.unwrap_err().to_string();
    assert!(error.starts_with("robot 1 is stuck: "), "{error}");
}
