//! The whole analysis of one net in one or several situations.

use super::closed::Closed;
use super::explored::{Explored, Fault};
use super::invariants::prove;
use super::never::Never;
use super::proof::Proof;
use super::refusal::{Reason, Refusal, Trace};
use super::report::{ByInvariants, Report};
use super::states::States;
#[cfg(feature = "symbolic")]
use super::symbolic::Symbolic;
use super::usage::{Limits, Situation, Use};
use crate::petri::NetModel;

/// Analyses a net from its initial marking; see [the module](super) for what is proved.
///
/// # Errors
/// The first fault found, with the shortest way there.
pub fn check(model: &NetModel, uses: &[Use], limits: &Limits) -> Result<Proof, Refusal> {
    let proofs = run(&[(None, model)], uses, limits)?;
    let only = proofs.into_iter().next();
    only.ok_or_else(|| refuse(model.name(), None, Box::new(Reason::NoSituation), None))
}

/// Analyses a net from each of several initial markings. A transition must fire, and an end be
/// reached, in one situation at least; everything else must hold in each. The situations are meant
/// to be one net, differing in nothing but marks.
///
/// # Errors
/// The first fault found, with the shortest way there.
pub fn check_situations(
    situations: &[Situation<'_>],
    uses: &[Use],
    limits: &Limits,
) -> Result<Vec<Proof>, Refusal> {
    let named: Vec<_> = situations.iter().map(|s| (Some(s.name), s.model)).collect();
    run(&named, uses, limits)
}

fn run(
    situations: &[(Option<&str>, &NetModel)],
    uses: &[Use],
    limits: &Limits,
) -> Result<Vec<Proof>, Refusal> {
    let Some(&(first_name, first)) = situations.first() else {
        return Err(refuse("?", None, Box::new(Reason::NoSituation), None));
    };
    let mut proofs: Vec<Proof> = Vec::with_capacity(situations.len());
    let mut never = Never::default();
    for &(name, model) in situations {
        let fails = |(reason, trace): Fault| refuse(model.name(), name, reason, trace);
        let closed = Closed::new(model, uses, limits);
        let mut closed = closed.map_err(|reason| fails((reason, None)))?;
        let by_invariants = prove(model, &mut closed, limits);
        let reading = (closed.layout, closed.counters().to_vec());
        let mut report = Report {
            net: model.name().to_owned(),
            situation: name.map(str::to_owned),
            states: 0,
            steps: 0,
            ends: Vec::new(),
            warnings: Vec::new(),
            by_invariants,
        };
        let states = explore(closed, limits, &mut report, &mut never)
            .map_err(|fault| fails(with_what_is_known(fault, &report.by_invariants)))?;
        proofs.push(Proof::new(
            model.clone(),
            uses.to_vec(),
            report,
            reading,
            states,
        ));
    }
    match never.reason(&proofs) {
        Some(reason) => Err(refuse(first.name(), first_name, Box::new(reason), None)),
        None => Ok(proofs),
    }
}

/// One state after another; if there are too many for that, all at once, where that is built in.
fn explore(
    closed: Closed<'_>,
    limits: &Limits,
    report: &mut Report,
    never: &mut Never,
) -> Result<States, Fault> {
    let found = match Explored::new(closed, limits) {
        Ok(found) => found,
        #[cfg(feature = "symbolic")]
        Err((closed, (reason, None))) if is_too_large(&reason) && limits.nodes > 0 => {
            let found = Symbolic::new(*closed, limits)?;
            never.add(&found);
            let (layout, all) = (found.closed.layout, found.all);
            (report.states, report.steps) = (all.states, all.steps);
            (report.ends, report.warnings) = (all.ends, all.warnings);
            return Ok(States::Together(layout, all.kept, all.meanings));
        }
        Err((_, fault)) => return Err(fault),
    };
    (report.ends, report.warnings) = found.prove()?;
    (report.states, report.steps) = (found.store.len() as u128, found.edges.len() as u128);
    never.add(&found);
    Ok(States::Each(found.store))
}

/// Adds to a search that was not finished what was known before.
pub(super) fn with_what_is_known((mut reason, trace): Fault, known: &ByInvariants) -> Fault {
    if let Reason::TooLarge { proved, .. } = &mut *reason
        && *known != ByInvariants::default()
    {
        *proved = known.to_string();
    }
    (reason, trace)
}

#[cfg(feature = "symbolic")]
fn is_too_large(reason: &Reason) -> bool {
    matches!(reason, Reason::TooLarge { .. })
}

fn refuse(
    net: &str,
    situation: Option<&str>,
    reason: Box<Reason>,
    trace: Option<Trace>,
) -> Refusal {
    Refusal {
        net: net.to_owned(),
        situation: situation.map(str::to_owned),
        reason,
        trace,
    }
}
