//! Times one net, with the marking perturbed between any two timed batches.

use std::collections::BTreeSet;
use std::hint::black_box;
use std::time::{Duration, Instant};

use coordination::event::EventTable;
use coordination::petri::{Budget, Executor, NetModel, PlaceId, Structure, TransitionId};

use crate::figure_4::{Figure4, Numbers, Rival};
use crate::random::Random;
use crate::reference::Reference;

/// Evaluations in a timed batch.
pub const EVALUATIONS: usize = 2_000;

/// Firings that are timed together, roughly.
const FIRINGS_IN_SLICE: usize = 2_000;

/// Firings that the reference executor compares in each batch, roughly.
const COMPARED: usize = 400;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    One,
    Saturated,
}

impl Mode {
    pub fn name(self) -> &'static str {
        match self {
            Self::One => "one",
            Self::Saturated => "saturated",
        }
    }

    fn budget(self) -> Budget {
        match self {
            Self::One => Budget::ONE,
            Self::Saturated => Budget::ROUND,
        }
    }
}

/// How long to measure.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Batches at least.
    pub least: usize,
    /// Batches at most.
    pub most: usize,
    /// No further batch beyond the least begins after this time.
    pub time: Duration,
}

impl Effort {
    pub fn wants_more(&self, batches: usize, since: Instant) -> bool {
        batches < self.least || batches < self.most && since.elapsed() < self.time
    }
}

/// Medians of one net in one mode, and how long the slowest slices took.
#[derive(Clone, Copy, Debug)]
pub struct Figures {
    pub ns_per_evaluation: f64,
    /// 99 of 100 slices took less.
    #[allow(dead_code, reason = "the benchmark does not print it")]
    pub tail_ns_per_evaluation: f64,
    pub firings_per_evaluation: f64,
}

impl Figures {
    pub fn ns_per_firing(&self) -> f64 {
        self.ns_per_evaluation / self.firings_per_evaluation
    }
}

/// Nanoseconds to make an executor from the model: ours, and the plain one if there is one. Of both,
/// checking and numbering the model is a part, which `check` is alone.
#[derive(Clone, Copy, Debug)]
pub struct Generation {
    pub ours: f64,
    pub theirs: Option<f64>,
    #[allow(dead_code, reason = "the benchmark and the check do not print it")]
    pub check: f64,
}

pub fn generation(model: &NetModel, rival: Option<&Rival>, effort: Effort) -> Generation {
    /// Of each in a batch.
    const GENERATIONS: usize = 20;
    let (mut ours, mut theirs, mut check) = (Vec::new(), Vec::new(), Vec::new());
    let numbers = Numbers::of(&model.structure().expect("the families are sound"));
    let mut batches = 0;
    let begin = Instant::now();
    while effort.wants_more(batches, begin) {
        for _ in 0..GENERATIONS {
            ours.push(time_one(|| {
                let net = black_box(model).compile(&mut EventTable::new());
                net.expect("the families are sound").executor()
            }));
        }
        for _ in 0..GENERATIONS {
            check.push(time_one(|| black_box(model).structure()));
        }
        for _ in 0..rival.map_or(0, |_| GENERATIONS) {
            theirs.extend(rival.map(|rival| {
                time_one(|| {
                    let structure = black_box(model).structure();
                    (structure, Figure4::new(rival, &numbers))
                })
            }));
        }
        batches += 1;
    }
    Generation {
        ours: median(ours),
        theirs: rival.map(|_| median(theirs)),
        check: median(check),
    }
}

/// Nanoseconds to make something; to drop it again is not timed.
fn time_one<T>(make: impl FnOnce() -> T) -> f64 {
    let start = Instant::now();
    let made = black_box(make());
    let ns = start.elapsed().as_nanos() as f64;
    drop(made);
    ns
}

/// Times evaluations: ours, and those of the plain executor if there is one, in turns.
pub fn evaluation(
    model: &NetModel,
    mode: Mode,
    rival: Option<&Rival>,
    effort: Effort,
) -> (Figures, Option<Figures>) {
    let net = model
        .compile(&mut EventTable::new())
        .expect("the families are sound");
    let structure = net.structure();
    let mut ours = net.executor();
    let numbers = Numbers::of(structure);
    let mut plain = rival.map(|rival| Figure4::new(rival, &numbers));
    let mut walk = Walk::new(structure);
    let (mut our_slices, mut their_slices) = (Vec::new(), Vec::new());
    let mut batches = 0;
    let in_slice = match mode {
        Mode::One => FIRINGS_IN_SLICE,
        Mode::Saturated => (FIRINGS_IN_SLICE / structure.transition_count()).max(1),
    };
    let begin = Instant::now();
    while effort.wants_more(batches, begin) {
        let marking = walk.next_marking(structure);
        ours.reset();
        ours.set_marking(&marking).expect("places of this net");
        compare_with_reference(model, &ours, &marking, mode);
        let mut again = ours.clone();

        time_batch(in_slice, &mut our_slices, |count| {
            evaluations(&mut ours, count, mode.budget())
        });
        compare_with_traced(&ours, &mut again, mode);

        if let Some(plain) = &mut plain {
            plain.set_marking(&marking);
            compare_plain_with_rule(structure, plain, mode);
            let firings = mode.budget().firings;
            time_batch(in_slice, &mut their_slices, |count| {
                plain.evaluations(count, firings)
            });
        }
        batches += 1;
    }
    (figures(&our_slices), rival.map(|_| figures(&their_slices)))
}

/// As the plain executor's function of that name.
fn evaluations(executor: &mut Executor, count: usize, budget: Budget) -> u64 {
    let all = (0..count).map(|_| u64::from(executor.evaluate(budget).fired));
    all.sum()
}

/// How many times as long one firing takes in a net as in another, measured in turns.
#[allow(dead_code, reason = "the benchmark does not compare sizes")]
pub fn ratio_of_ones(model: &NetModel, other: &NetModel, effort: Effort) -> f64 {
    let mut slices = [Vec::new(), Vec::new()];
    let mut executors = [model, other].map(|model| {
        let net = model.compile(&mut EventTable::new());
        net.expect("the families are sound").executor()
    });
    let mut batches = 0;
    let begin = Instant::now();
    while effort.wants_more(batches, begin) {
        for (executor, slices) in executors.iter_mut().zip(&mut slices) {
            time_batch(FIRINGS_IN_SLICE, slices, |count| {
                evaluations(executor, count, Mode::One.budget())
            });
        }
        batches += 1;
    }
    let [ours, others] = slices.map(|slices| figures(&slices).ns_per_firing());
    ours / others
}

/// Evaluations that were timed together.
#[derive(Clone, Copy)]
struct Slice {
    ns_per_evaluation: f64,
    firings_per_evaluation: f64,
}

/// A batch of evaluations, in slices that are too short to be disturbed often.
fn time_batch(in_slice: usize, slices: &mut Vec<Slice>, mut evaluate: impl FnMut(usize) -> u64) {
    let mut left = EVALUATIONS;
    while left > 0 {
        let count = left.min(in_slice);
        left -= count;
        let start = Instant::now();
        let fired = evaluate(count);
        let ns = start.elapsed().as_nanos();
        slices.push(Slice {
            ns_per_evaluation: ns as f64 / count as f64,
            firings_per_evaluation: fired as f64 / count as f64,
        });
    }
}

fn figures(slices: &[Slice]) -> Figures {
    let all = |of: fn(&Slice) -> f64| slices.iter().map(of).collect();
    Figures {
        ns_per_evaluation: median(all(|slice| slice.ns_per_evaluation)),
        tail_ns_per_evaluation: quantile(all(|slice| slice.ns_per_evaluation), 0.99),
        firings_per_evaluation: median(all(|slice| slice.firings_per_evaluation)),
    }
}

fn median(values: Vec<f64>) -> f64 {
    quantile(values, 0.5)
}

pub fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values[(values.len() as f64 * share) as usize]
}

/// A walk at random through the markings that the net can reach.
struct Walk {
    marked: Vec<bool>,
    random: Random,
}

impl Walk {
    fn new(net: &Structure) -> Self {
        Self {
            marked: net.places().map(|place| net.marked(place)).collect(),
            random: Random::new(),
        }
    }

    /// Fires up to as many enabled transitions as there are places, each chosen at random.
    fn next_marking(&mut self, net: &Structure) -> Vec<PlaceId> {
        let steps = self.random.below(net.place_count());
        for _ in 0..steps {
            let first = self.random.below(net.transition_count());
            let all = net.transitions();
            let mut in_turn = all.clone().skip(first).chain(all.take(first));
            if let Some(transition) = in_turn.find(|&t| is_enabled(net, &self.marked, t)) {
                fire(net, &mut self.marked, transition);
            }
        }
        let places = net.places();
        places.filter(|place| self.marked[place.index()]).collect()
    }
}

fn is_enabled(net: &Structure, marked: &[bool], transition: TransitionId) -> bool {
    let inputs = net.inputs(transition);
    inputs.iter().all(|place| marked[place.index()])
}

fn fire(net: &Structure, marked: &mut [bool], transition: TransitionId) {
    for place in net.inputs(transition) {
        marked[place.index()] = false;
    }
    for place in net.outputs(transition) {
        marked[place.index()] = true;
    }
}

/// The first evaluations of the coming batch, transition by transition.
fn compare_with_reference(model: &NetModel, ours: &Executor, marking: &[PlaceId], mode: Mode) {
    let mut ours = ours.clone();
    let mut simple = Reference::new(model);
    let marking: BTreeSet<_> = marking.iter().map(|place| place.index()).collect();
    simple.set_marking(marking);
    let mut trace = vec![TransitionId(0); model.transitions().len()];
    let mut compared = 0;
    while compared < COMPARED {
        let evaluation = ours.evaluate_traced(mode.budget(), &mut trace);
        let fired = &trace[..evaluation.fired as usize];
        let firings = mode.budget().firings as usize;
        let expected = simple.evaluate(firings.min(trace.len()), 1);
        let found: Vec<_> = fired.iter().map(|transition| transition.index()).collect();
        assert_eq!(found, expected.fired, "{}: other firings", model.name());
        assert_eq!(evaluation.remaining, expected.remaining);
        assert!(!fired.is_empty(), "{}: nothing fires", model.name());
        compared += fired.len();
    }
}

/// The timed batch ends as a traced one does that goes through every firing by the rule.
fn compare_with_traced(timed: &Executor, again: &mut Executor, mode: Mode) {
    let net = timed.net();
    let structure = net.structure();
    let mut marked: Vec<_> = net.places().map(|place| again.is_marked(place)).collect();
    let mut trace = vec![TransitionId(0); structure.transition_count()];
    for _ in 0..EVALUATIONS {
        let evaluation = again.evaluate_traced(mode.budget(), &mut trace);
        for &transition in &trace[..evaluation.fired as usize] {
            assert!(is_enabled(structure, &marked, transition));
            fire(structure, &mut marked, transition);
        }
    }
    for place in net.places() {
        assert_eq!(timed.is_marked(place), marked[place.index()]);
    }
}

/// The plain executor fires only what is enabled, and leaves nothing that it should fire: in these
/// families the same as ours, in the order of its own list.
fn compare_plain_with_rule(net: &Structure, plain: &mut Figure4<'_>, mode: Mode) {
    let mut marked: Vec<_> = net.places().map(|place| plain.is_marked(place)).collect();
    let mut fired = BTreeSet::new();
    for transition in plain.traced(mode.budget().firings) {
        assert!(is_enabled(net, &marked, transition));
        fire(net, &mut marked, transition);
        assert!(fired.insert(transition), "fired twice");
    }
    for place in net.places() {
        assert_eq!(plain.is_marked(place), marked[place.index()]);
    }
    match mode {
        Mode::One => assert_eq!(fired.len(), 1, "one evaluation fires one"),
        Mode::Saturated => {
            let left =
                { net.transitions() }.find(|t| !fired.contains(t) && is_enabled(net, &marked, *t));
            assert_eq!(left, None, "not saturated");
        }
    }
}
