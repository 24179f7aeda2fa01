//! What is true of a net as such, whether it may run or not: how many states it has, deadlocks, which
//! markings it reaches, and the liveness of each transition.
//!
//! [`check`](super::check()) says whether a net may run, and stops at the first fault. This answers what the
//! tools for nets answer (the examinations of the Model Checking Contest: state space, deadlock, one-safe,
//! quasi-liveness, liveness, reachability), also of nets that come to an end or to a halt, with the same two
//! searches and the same [`Limits`]. It is a net with its protocols as [the analysis](super) closes it;
//! without protocols it is the net as it stands.

use super::check::with_what_is_known;
use super::closed::Closed;
use super::explored::{Explored, Fault};
use super::findings::{Deaths, Findings, Liveness, Target};
use super::invariants::prove;
use super::refusal::{Reason, Refusal, Trace};
use super::report::ByInvariants;
#[cfg(feature = "symbolic")]
use super::symbolic::list;
use super::usage::{Limits, Use};
use crate::petri::NetModel;

/// A marking, as far as it matters: other places may be marked or empty.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Marking {
    /// Places that are marked.
    pub marked: Vec<String>,
    /// Places that are empty.
    pub empty: Vec<String>,
}

impl Marking {
    /// The markings in which these places are marked and those are empty.
    #[must_use]
    pub fn new(marked: &[&str], empty: &[&str]) -> Self {
        let own = |places: &[&str]| places.iter().map(|&place| place.to_owned()).collect();
        Self {
            marked: own(marked),
            empty: own(empty),
        }
    }
}

/// What is true of a net; see [`properties`].
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Properties {
    /// The net.
    pub net: String,
    /// How many states it can reach; the largest number if there are more.
    pub states: u128,
    /// How many steps there are between them; the largest number if there are more.
    pub steps: u128,
    /// The way to a nearest state in which nothing can happen any more, a declared end or not.
    pub deadlock: Option<Trace>,
    /// Each transition by its name, in the model's order.
    pub transitions: Vec<(String, Liveness)>,
    /// For each marking asked for, the way to a nearest state that has it, if there is one.
    pub reached: Vec<Option<Trace>>,
    /// What was proved before any state was looked at.
    pub by_invariants: ByInvariants,
    deaths: Deaths,
}

impl Properties {
    /// Whether each transition is live (Murata's L4).
    #[must_use]
    pub fn is_live(&self) -> bool {
        let mut all = self.transitions.iter();
        all.all(|(_, liveness)| *liveness == Liveness::Live)
    }

    /// Whether each transition can fire at least once (Murata's L1).
    #[must_use]
    pub fn is_quasi_live(&self) -> bool {
        let mut all = self.transitions.iter();
        all.all(|(_, liveness)| *liveness != Liveness::Dead)
    }

    /// The way to where a transition, by its number in [`transitions`](Self::transitions), dies: to a nearest
    /// deadlock if there is one, else to a nearest state from which it cannot fire any more. None if
    /// it does not die; or if looking at the states for those before it has used up [`Limits::looks`], or their ways
    /// have used up [`Limits::steps`].
    #[must_use]
    pub fn dies_after(&self, transition: usize) -> Option<&Trace> {
        match (self.transitions.get(transition)?.1, &self.deadlock) {
            (Liveness::Dies, Some(deadlock)) => Some(deadlock),
            (Liveness::Dies, None) => self.deaths.way(transition),
            _ => None,
        }
    }
}

/// Looks at all states of a net with its protocols, and says what is true of it and which of `markings` it
/// reaches. A place that nothing fills or nothing empties is no fault here. Not for real-time threads.
///
/// ```
/// use coordination::analysis::{Limits, Liveness, Marking, properties};
/// use coordination::petri::NetModel;
///
/// let mut fuse = NetModel::new("fuse");
/// fuse.place("on").mark("on").place("off").place("blown");
/// fuse.transition("switch off", &["on"], &["off"]).transition("switch on", &["off"], &["on"]);
/// fuse.transition("blow", &["on"], &["blown"]);
///
/// let asked = [Marking::new(&["blown"], &[]), Marking::new(&["on", "off"], &[])];
/// let found = properties(&fuse, &[], &Limits::default(), &asked)?;
/// assert_eq!(found.states, 3);
/// let deadlock = found.deadlock.as_ref().expect("a fuse blows");
/// assert_eq!(deadlock.to_string(), "blow");
/// assert_eq!(found.transitions[0], ("switch off".to_owned(), Liveness::Dies));
/// assert_eq!(found.dies_after(0), Some(deadlock));
/// assert_eq!(found.reached, [Some(deadlock.clone()), None]);
/// # Ok::<(), coordination::analysis::Refusal>(())
/// ```
///
/// # Errors
/// If the model does not compile for other reasons, a marking names a place that the net does not have, the
/// net is too large for the limits; or it is not safe or events overflow, so that it is not defined what
/// happens then.
pub fn properties(
    model: &NetModel,
    uses: &[Use],
    limits: &Limits,
    markings: &[Marking],
) -> Result<Properties, Refusal> {
    let fails = |(reason, trace): Fault| Refusal {
        net: model.name().to_owned(),
        situation: None,
        reason,
        trace,
    };
    let closed = Closed::of_any(model, uses, limits);
    let mut closed = closed.map_err(|reason| fails((reason, None)))?;
    let by_invariants = prove(model, &mut closed, limits);
    let targets: Result<Vec<_>, _> = { markings.iter() }
        .map(|marking| target(&closed, marking))
        .collect();
    let targets = targets.map_err(|reason| fails((reason, None)))?;
    let names: Vec<String> = { 0..closed.transitions() }
        .map(|transition| closed.transition_name(transition).to_owned())
        .collect();
    let found = find(closed, limits, &targets)
        .map_err(|fault| fails(with_what_is_known(fault, &by_invariants)))?;
    Ok(Properties {
        net: model.name().to_owned(),
        states: found.states,
        steps: found.steps,
        deadlock: found.deadlock,
        transitions: names.into_iter().zip(found.liveness).collect(),
        reached: found.reached,
        by_invariants,
        deaths: found.deaths,
    })
}

fn target(closed: &Closed<'_>, marking: &Marking) -> Result<Target, Box<Reason>> {
    let find = |places: &[String]| -> Result<Vec<u32>, Box<Reason>> {
        let numbers = places.iter().map(|place| {
            let place = place.clone();
            let number = closed.place_number(&place);
            number.ok_or_else(|| Box::new(Reason::UnknownPlace { place }))
        });
        numbers.collect()
    };
    Ok(Target {
        marked: find(&marking.marked)?,
        empty: find(&marking.empty)?,
    })
}

/// One state after another; if there are too many for that, all at once, where that is built in.
fn find(closed: Closed<'_>, limits: &Limits, targets: &[Target]) -> Result<Findings, Fault> {
    match Explored::listed(closed, limits) {
        Ok(explored) => Ok(explored.findings(targets, limits)),
        #[cfg(feature = "symbolic")]
        Err((closed, (reason, None)))
            if matches!(*reason, Reason::TooLarge { .. }) && limits.nodes > 0 =>
        {
            list(&closed, limits, targets)
        }
        Err((_, fault)) => Err(fault),
    }
}
