//! Roles and their protocols.

use std::collections::BTreeSet;
use std::sync::Arc;

use ::coordination::protocol::Problem as Fault;

use super::names::repeated;
use crate::check::reference::unknown;
use crate::diagnostic::ProblemKind;
use crate::net::{MEDIATOR, NetConfig, NetProtocol};
use crate::report::Report;

/// The most arrays of a protocol.
const MOST_ARRAYS: usize = 64;
/// The most flags of all arrays of a protocol together.
const MOST_FLAGS: usize = 256;

pub(super) fn sizes(net: &NetConfig, report: &Report) -> bool {
    let mut good = true;
    for protocol in &net.protocols {
        let flags: usize = protocol.arrays.iter().map(|array| array.flags.len()).sum();
        let follow: usize = protocol.arrays.iter().map(|array| array.then.len()).sum();
        for (what, found, most) in [
            ("arrays", protocol.arrays.len(), MOST_ARRAYS),
            ("flags", flags, MOST_FLAGS),
            ("ways from array to array", follow, MOST_FLAGS),
        ] {
            if found > most {
                good = false;
                let key = format!("protocols.{}", protocol.id);
                let (found, expected) = (format!("{found} {what}"), format!("at most {most}"));
                report.wrong(ProblemKind::OutOfRange, &key, found, expected);
            }
        }
    }
    good
}

pub(super) fn check(net: &mut NetConfig, report: &Report) {
    let ids: Vec<&str> = net.protocols.iter().map(|own| own.id.as_str()).collect();
    for role in &net.roles {
        let key = format!("roles.{}", role.id);
        if role.id == MEDIATOR {
            let found = format!("a role called `{MEDIATOR}`");
            let expected = "names of robots' roles; the mediator always takes part";
            report.wrong(ProblemKind::OutOfRange, &key, found, expected);
        }
        if !role.protocol.is_empty() && !ids.contains(&role.protocol.as_str()) {
            unknown(
                report,
                &format!("{key}.protocol"),
                &role.protocol,
                "protocol",
                &ids,
            );
        }
    }
    if net.roles.is_empty() && !report.touched(&["roles"]) {
        let expected = "at least one role";
        report.wrong(
            ProblemKind::OutOfRange,
            "roles",
            "an empty section",
            expected,
        );
    }
    for protocol in &net.protocols {
        let key = format!("protocols.{}", protocol.id);
        if !net.roles.iter().any(|role| role.protocol == protocol.id) && !report.touched(&["roles"])
        {
            let found = format!("protocol `{}`, which no role has", protocol.id);
            report.wrong(ProblemKind::Inconsistent, &key, found, "protocols of roles");
        }
        references(&key, protocol, report);
    }
    let mut compiled = Vec::new();
    for role in &net.roles {
        let Some(protocol) = net.protocols.iter().find(|own| own.id == role.protocol) else {
            continue;
        };
        let key = format!("protocols.{}", protocol.id);
        if role.id == MEDIATOR || report.touched(&[&key]) {
            continue;
        }
        match protocol.model(&role.id).compile() {
            Ok(made) => compiled.push((role.id.clone(), Arc::new(made))),
            Err(error) => fault(&key, protocol, &error.problem, report),
        }
    }
    net.compiled = compiled.into_iter().collect();
}

fn references(key: &str, protocol: &NetProtocol, report: &Report) {
    let arrays: Vec<&str> = protocol.arrays.iter().map(|own| own.id.as_str()).collect();
    let known: BTreeSet<&str> = arrays.iter().copied().collect();
    let check = |key: &str, names: &[String]| {
        for (index, name) in names.iter().enumerate() {
            if !name.is_empty() && !known.contains(name.as_str()) {
                unknown(report, &format!("{key}[{index}]"), name, "array", &arrays);
            }
        }
        repeated(report, key, names);
    };
    check(&format!("{key}.start"), &protocol.start);
    for array in &protocol.arrays {
        check(&format!("{key}.arrays.{}.then", array.id), &array.then);
    }
}

/// What makes a protocol impossible, at the array that it is about.
fn fault(key: &str, protocol: &NetProtocol, fault: &Fault, report: &Report) {
    let array = match fault {
        Fault::Cycle { array } | Fault::Unreachable { array } => Some(array),
        Fault::SetTwice { array, .. } => Some(array),
        _ => None,
    };
    // A protocol of one array has no section for it.
    let key = match array {
        Some(array) if report.origin.is_written(&format!("{key}.arrays")) => {
            format!("{key}.arrays.{array}")
        }
        _ => key.to_owned(),
    };
    let found = format!("protocol `{}`{fault}", protocol.id);
    let expected = "flags in an order that both parties can follow to an end";
    report.wrong(ProblemKind::Inconsistent, &key, found, expected);
}
