//! What both fuzz targets do with a net that the analysis has passed: run it, with robots that do
//! anything they may, and see that nothing happens that was proved impossible.

use coordination::analysis::{Limits, Proof, Use};
use coordination::binding::NetBinding;
use coordination::event::{EventId, EventTable};
use coordination::petri::{Binding, Budget, NetModel, PlaceKind};
use coordination::protocol::{End, Position, SetError, Side, channel};

/// Little enough that one input takes milliseconds.
pub const LIMITS: Limits = Limits {
    states: 2_000,
    steps: 20_000,
    looks: 200_000,
    nodes: 0,
    time: std::time::Duration::ZERO,
    waiting: 2,
};

/// How many times robots and net take turns.
const TURNS: usize = 200;

/// Numbers that only look random (xorshift).
struct Coin(u64);

impl Coin {
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as usize % limit
    }
}

/// Runs a net. If the analysis has passed it, what it proved must hold.
pub fn run(model: &NetModel, uses: &[Use], proof: Option<&Proof>, seed: u64) {
    let mut events = EventTable::new();
    let Ok(net) = model.compile(&mut events) else {
        assert!(proof.is_none(), "what passes the analysis compiles");
        return;
    };
    let (mut robots, mut sides) = (Vec::new(), Vec::new());
    for used in uses {
        let (first, second) = channel(&used.protocol);
        let (robot, own) = match used.net_party.index() {
            0 => (second, first),
            _ => (first, second),
        };
        robots.push(robot);
        sides.push((used.name.clone(), own));
    }
    let made = match proof {
        Some(proof) => NetBinding::new(proof, &net, sides),
        None => NetBinding::unproved(&net, sides),
    };
    let Ok(mut binding) = made else {
        assert!(proof.is_none(), "what passes the analysis can be bound");
        return;
    };
    let free: Vec<EventId> = model
        .places()
        .filter(|place| place.kind == PlaceKind::Source)
        .filter_map(|place| match place.binding {
            Some(Binding::Event(event)) => events.id(event),
            _ => None,
        })
        .collect();
    let mut coin = Coin(seed | 1);
    for _ in 0..TURNS {
        for robot in &mut robots {
            if coin.below(2) == 0 {
                turn(robot, &mut coin);
            }
        }
        if !free.is_empty() && coin.below(2) == 0 {
            let _ = binding.offer(free[coin.below(free.len())]);
        }
        let budget = Budget {
            firings: 1 + coin.below(8) as u32,
            ..Budget::default()
        };
        let takes = coin.below(2) == 0;
        binding.step(budget, |_| takes);
        if let Some(proof) = proof {
            assert!(binding.is_proved_by(proof), "the analysis has not looked there");
            judge(model, &binding);
        }
    }
}

/// The robot sets one of the flags that it may set.
fn turn(robot: &mut End, coin: &mut Coin) {
    while robot.poll().is_some() {}
    let at = match robot.position() {
        at if robot.protocol().is_end(at) => Position::START,
        at => at,
    };
    let next: Vec<_> = robot.protocol().next(at).collect();
    if let Some(&(flag, _)) = next.get(coin.below(next.len().max(1))) {
        let _ = robot.set(flag);
    }
}

/// What the analysis proved, at this moment.
fn judge(model: &NetModel, binding: &NetBinding<End>) {
    let executor = binding.executor();
    let net = executor.net();
    let is_marked = |place: &str| net.place_id(place).is_some_and(|id| executor.is_marked(id));
    for exclusion in model.exclusions() {
        let marked = exclusion.places.iter().filter(|place| is_marked(place));
        assert!(
            marked.count() <= 1,
            "exclusion `{}` is broken",
            exclusion.name
        );
    }
    for transition in model.transitions() {
        let own = |place: &&&str| transition.inputs.contains(*place);
        let mut full = transition
            .outputs
            .iter()
            .filter(|place| !own(place) && is_marked(place));
        // A full sink may hold it back; anything else would be a second token.
        let kind = |name: &str| {
            model
                .places()
                .find(|p| p.name == name)
                .map(|place| place.kind)
        };
        if transition.inputs.iter().all(|place| is_marked(place))
            && let Some(place) = full.next()
            && full.all(|place| kind(place) == Some(PlaceKind::Internal))
        {
            assert_eq!(
                kind(place),
                Some(PlaceKind::Sink),
                "`{place}` would get a second token"
            );
        }
    }
    for (protocol, _, error) in binding.refusals() {
        assert!(
            !matches!(error, SetError::NotYours { .. } | SetError::Unknown { .. }),
            "protocol `{protocol}`: {error}"
        );
    }
}
