//! Whatever a file holds, loading it returns: it never panics and never hangs, and
//! a problem always names its file and points into its text.

use crate::common::mutation::{apply, change, sound, value};
use crate::common::{ROBOT, SITE};
use config::{Override, check_together, parse_robot, parse_site};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_mutated_robot_file_never_panics(changes in prop::collection::vec(change(), 1..6)) {
        let text = apply(ROBOT, &changes);
        match parse_robot("some.toml", &text, &[]) {
            Ok(robot) => {
                let site = parse_site("site.toml", SITE, &[]).expect("the shipped site");
                let _ = check_together(&robot, &site);
            }
            Err(error) => sound(&error, &text),
        }
    }

    #[test]
    fn a_mutated_site_file_never_panics(changes in prop::collection::vec(change(), 1..6)) {
        let text = apply(SITE, &changes);
        match parse_site("some.toml", &text, &[]) {
            Ok(site) => {
                let robot = parse_robot("robot.toml", ROBOT, &[]).expect("the shipped robot");
                let _ = check_together(&robot, &site);
            }
            Err(error) => sound(&error, &text),
        }
    }

    #[test]
    fn any_text_never_panics(text in any::<String>()) {
        if let Err(error) = parse_robot("some.toml", &text, &[]) {
            sound(&error, &text);
        }
        if let Err(error) = parse_site("some.toml", &text, &[]) {
            sound(&error, &text);
        }
    }

    #[test]
    fn any_override_never_panics(
        key in "(drive|tubes|threads|areas|fsm)(\\.[a-z_0-9\\-\"é]{0,12}){0,3}",
        value in value(),
    ) {
        if let Ok(good) = Override::parse(&format!("{key}={value}")) {
            let _ = parse_robot("some.toml", ROBOT, std::slice::from_ref(&good));
            let _ = parse_site("some.toml", SITE, &[good]);
        }
    }
}

#[test]
fn deep_nesting_is_refused_and_not_followed() {
    for opening in ["[", "{ a = "] {
        let text = format!("name = {}", opening.repeat(100_000));
        let error = parse_site("some.toml", &text, &[]).unwrap_err();
        sound(&error, &text);
    }
    let path = "a.".repeat(100_000);
    for text in [
        format!("{path}a = 1"),
        format!("[{path}a]\nb = 1"),
        format!("name = {{ {path}a = 1 }}"),
    ] {
        let error = parse_site("some.toml", &text, &[]).unwrap_err();
        sound(&error, &text);
    }
}
