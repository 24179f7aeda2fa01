//! Key expressions on the fleet's network.
//!
//! `PREFIX/robots/ID/state` carries [`crate::wire::RobotState`], on change and at 5 Hz;
//! `PREFIX/robots/ID/alive` is the robot's liveliness token, gone when the robot is;
//! `PREFIX/robots/ID/report` carries [`crate::wire::RobotReport`] to the mediator;
//! `PREFIX/mediator/to/ID` carries [`crate::wire::MediatorReport`] to one robot;
//! `PREFIX/mediator/alive` is the mediator's liveliness token, and `PREFIX/mediator/alive/INSTANCE` tells which process it is of.
//!
//! Where certificates are asked for, also: `PREFIX/robots/ID/certificate` is asked with
//! [`crate::wire::CertificateRequest`], and answers [`crate::wire::CertificateAnswer`];
//! `PREFIX/operators/NAME/question` is asked by that operator.

use description::names::{is_key_part, is_key_prefix};

/// Why a name cannot be part of a key.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{what} `{found}` cannot be part of a key: expected letters, digits, `-`, `_` or `.`, at least one"
)]
pub struct InvalidName {
    /// Which name it is, such as "robot id".
    pub what: &'static str,
    /// The name as found.
    pub found: String,
}

/// Key of a robot's state.
///
/// # Errors
/// [`InvalidName`] when prefix or id are not plain names.
pub fn state(prefix: &str, robot_id: &str) -> Result<String, InvalidName> {
    robot_key(prefix, robot_id, "state")
}

/// Key of a robot's liveliness token.
///
/// # Errors
/// [`InvalidName`] when prefix or id are not plain names.
pub fn alive(prefix: &str, robot_id: &str) -> Result<String, InvalidName> {
    robot_key(prefix, robot_id, "alive")
}

/// Key of a robot's report to the mediator.
///
/// # Errors
/// [`InvalidName`] when prefix or id are not plain names.
pub fn report(prefix: &str, robot_id: &str) -> Result<String, InvalidName> {
    robot_key(prefix, robot_id, "report")
}

/// Key of the mediator's report to a robot.
///
/// # Errors
/// [`InvalidName`] when prefix or id are not plain names.
pub fn to_robot(prefix: &str, robot_id: &str) -> Result<String, InvalidName> {
    check_prefix(prefix)?;
    check_robot_id(robot_id)?;
    Ok(format!("{prefix}/mediator/to/{robot_id}"))
}

/// Key of the mediator's liveliness token.
///
/// # Errors
/// [`InvalidName`] when the prefix is not a plain path.
pub fn mediator_alive(prefix: &str) -> Result<String, InvalidName> {
    check_prefix(prefix)?;
    Ok(format!("{prefix}/mediator/alive"))
}

/// Key of the liveliness token by which a mediator's process is told from others: its instance, in 16 hexadecimal digits.
///
/// # Errors
/// [`InvalidName`] when the prefix is not a plain path.
pub fn mediator_instance(prefix: &str, instance: u64) -> Result<String, InvalidName> {
    check_prefix(prefix)?;
    Ok(format!("{prefix}/mediator/alive/{instance:016x}"))
}

/// Expression that matches the token of every mediator's process under `prefix`.
///
/// # Errors
/// [`InvalidName`] when the prefix is not a plain path.
pub fn all_mediator_instances(prefix: &str) -> Result<String, InvalidName> {
    check_prefix(prefix)?;
    Ok(format!("{prefix}/mediator/alive/*"))
}

/// The instance that such a key names.
#[must_use]
pub fn instance_in(key: &str) -> Option<u64> {
    let last = key.rsplit('/').next()?;
    u64::from_str_radix(last, 16).ok()
}

/// Key under which a robot asks for its next certificate.
///
/// # Errors
/// [`InvalidName`] when prefix or id are not plain names.
pub fn certificate(prefix: &str, robot_id: &str) -> Result<String, InvalidName> {
    robot_key(prefix, robot_id, "certificate")
}

/// Key under which an operator asks the mediator.
///
/// # Errors
/// [`InvalidName`] when prefix or name are not plain names.
pub fn question(prefix: &str, operator: &str) -> Result<String, InvalidName> {
    check_prefix(prefix)?;
    check_part("operator's name", operator)?;
    Ok(format!("{prefix}/operators/{operator}/question"))
}

/// Expression that matches the requests for certificates of every robot under `prefix`.
///
/// # Errors
/// [`InvalidName`] when the prefix is not a plain path.
pub fn all_certificates(prefix: &str) -> Result<String, InvalidName> {
    check_prefix(prefix)?;
    Ok(format!("{prefix}/robots/*/certificate"))
}

/// Expression that matches the questions of every operator under `prefix`.
///
/// # Errors
/// [`InvalidName`] when the prefix is not a plain path.
pub fn all_questions(prefix: &str) -> Result<String, InvalidName> {
    check_prefix(prefix)?;
    Ok(format!("{prefix}/operators/*/question"))
}

/// Expression that matches the liveliness token of every robot under `prefix`.
///
/// # Errors
/// [`InvalidName`] when the prefix is not a plain path.
pub fn all_alive(prefix: &str) -> Result<String, InvalidName> {
    check_prefix(prefix)?;
    Ok(format!("{prefix}/robots/*/alive"))
}

/// Expression that matches the reports of every robot under `prefix`.
///
/// # Errors
/// [`InvalidName`] when the prefix is not a plain path.
pub fn all_reports(prefix: &str) -> Result<String, InvalidName> {
    check_prefix(prefix)?;
    Ok(format!("{prefix}/robots/*/report"))
}

/// Expression that matches what the mediator says to every robot under `prefix`.
///
/// # Errors
/// [`InvalidName`] when the prefix is not a plain path.
pub fn to_all_robots(prefix: &str) -> Result<String, InvalidName> {
    check_prefix(prefix)?;
    Ok(format!("{prefix}/mediator/to/*"))
}

/// Expression that matches the state of every robot under `prefix`.
///
/// # Errors
/// [`InvalidName`] when the prefix is not a plain path.
pub fn all_states(prefix: &str) -> Result<String, InvalidName> {
    check_prefix(prefix)?;
    Ok(format!("{prefix}/robots/*/state"))
}

fn robot_key(prefix: &str, robot_id: &str, leaf: &str) -> Result<String, InvalidName> {
    check_prefix(prefix)?;
    check_robot_id(robot_id)?;
    Ok(format!("{prefix}/robots/{robot_id}/{leaf}"))
}

fn check_robot_id(robot_id: &str) -> Result<(), InvalidName> {
    check_part("robot id", robot_id)
}

fn check_part(what: &'static str, name: &str) -> Result<(), InvalidName> {
    if is_key_part(name) {
        return Ok(());
    }
    Err(InvalidName {
        what,
        found: name.into(),
    })
}

fn check_prefix(prefix: &str) -> Result<(), InvalidName> {
    if is_key_prefix(prefix) {
        Ok(())
    } else {
        Err(InvalidName {
            what: "key prefix",
            found: prefix.into(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_built_from_plain_names() {
        assert_eq!(
            state("hall/a", "amr-1").as_deref(),
            Ok("hall/a/robots/amr-1/state")
        );
        assert_eq!(
            alive("fleet", "amr-1").as_deref(),
            Ok("fleet/robots/amr-1/alive")
        );
        assert_eq!(all_states("fleet").as_deref(), Ok("fleet/robots/*/state"));
        assert_eq!(
            report("fleet", "amr-1").as_deref(),
            Ok("fleet/robots/amr-1/report")
        );
        assert_eq!(
            to_robot("fleet", "amr-1").as_deref(),
            Ok("fleet/mediator/to/amr-1")
        );
        assert_eq!(
            mediator_alive("fleet").as_deref(),
            Ok("fleet/mediator/alive")
        );
        let token = mediator_instance("fleet", 0xbeef).expect("a plain name");
        assert_eq!(token, "fleet/mediator/alive/000000000000beef");
        assert_eq!(instance_in(&token), Some(0xbeef));
        assert_eq!(instance_in("fleet/mediator/alive"), None);
        assert_eq!(
            all_mediator_instances("fleet").as_deref(),
            Ok("fleet/mediator/alive/*")
        );
        assert_eq!(all_reports("fleet").as_deref(), Ok("fleet/robots/*/report"));
        assert_eq!(to_all_robots("fleet").as_deref(), Ok("fleet/mediator/to/*"));
    }

    #[test]
    fn wildcards_and_empty_names_are_refused() {
        assert!(state("fleet", "*").is_err());
        assert!(state("fleet", "a/b").is_err());
        assert!(state("", "a").is_err());
        assert!(all_states("fleet/").is_err());
    }
}
