//! Safe families of the Model Checking Contest (<https://mcc.lip6.fr>), written from their definitions.

use coordination::petri::NetModel;

/// A name, inputs and outputs.
pub type Transition = (String, Vec<String>, Vec<String>);

/// Places, marked or not; transitions with their inputs and outputs.
#[derive(Clone, Default)]
pub struct Net {
    pub places: Vec<(String, bool)>,
    pub transitions: Vec<Transition>,
}

impl Net {
    /// As a model of ours.
    pub fn model(&self) -> NetModel {
        let mut model = NetModel::new("family");
        for (place, marked) in &self.places {
            model.place(place);
            if *marked {
                model.mark(place);
            }
        }
        for (name, inputs, outputs) in &self.transitions {
            let [inputs, outputs] =
                [inputs, outputs].map(|list| list.iter().map(String::as_str).collect::<Vec<_>>());
            model.transition(name, &inputs, &outputs);
        }
        model
    }

    fn place(&mut self, name: String, marked: bool) {
        self.places.push((name, marked));
    }

    fn transition<const I: usize, const O: usize>(
        &mut self,
        name: String,
        inputs: [String; I],
        outputs: [String; O],
    ) {
        self.transitions.push((name, inputs.into(), outputs.into()));
    }
}

/// Each takes either fork first, then the other, and puts both down at once.
pub fn philosophers(count: usize) -> Net {
    let mut net = Net::default();
    for own in 0..count {
        let at = |what: &str| format!("{what} {own}");
        let (left, right) = (at("fork"), format!("fork {}", (own + 1) % count));
        let [think, one, other, eat] = ["think", "catch 1", "catch 2", "eat"].map(at);
        for (place, marked) in [
            (&left, true),
            (&think, true),
            (&one, false),
            (&other, false),
            (&eat, false),
        ] {
            net.place(place.clone(), marked);
        }
        let own = |list: [&String; 2]| list.map(String::clone);
        net.transition(at("FF1a"), own([&think, &left]), [one.clone()]);
        net.transition(at("FF1b"), own([&think, &right]), [other.clone()]);
        net.transition(at("FF2a"), own([&one, &right]), [eat.clone()]);
        net.transition(at("FF2b"), own([&other, &left]), [eat.clone()]);
        net.transition(at("end"), [eat], [think, left, right]);
    }
    net
}

/// Processors that work, use their own memory, or queue for the bus to another's. One comes to an end with
/// its own only while no other uses it.
pub fn shared_memory(count: usize) -> Net {
    let mut net = Net::default();
    net.place("bus".into(), true);
    for own in 0..count {
        let at = |what: &str| format!("{what} {own}");
        for (what, marked) in [
            ("active", true),
            ("memory", true),
            ("own", false),
            ("queue", false),
        ] {
            net.place(at(what), marked);
        }
        net.transition(at("begin own"), [at("active")], [at("own")]);
        let (using, done) = ([at("own"), at("memory")], [at("active"), at("memory")]);
        net.transition(at("end own"), using, done);
        net.transition(at("request"), [at("active")], [at("queue")]);
        for other in (0..count).filter(|&other| other != own) {
            let (access, memory) = (format!("access {own} {other}"), format!("memory {other}"));
            net.place(access.clone(), false);
            let begin = [at("queue"), "bus".into(), memory.clone()];
            net.transition(format!("begin {own} {other}"), begin, [access.clone()]);
            let end = [at("active"), "bus".into(), memory];
            net.transition(format!("end {own} {other}"), [access], end);
        }
    }
    net
}

/// Dekker's algorithm: one raises a flag, takes it back if another's is up, or enters if none is.
pub fn dekker(count: usize) -> Net {
    let mut net = Net::default();
    for own in 0..count {
        let at = |what: &str| format!("{what} {own}");
        for (what, marked) in [
            ("p0", true),
            ("p1", false),
            ("p3", false),
            ("down", true),
            ("up", false),
        ] {
            net.place(at(what), marked);
        }
        net.transition(at("try"), [at("p0"), at("down")], [at("p1"), at("up")]);
        net.transition(at("exit"), [at("p3"), at("up")], [at("p0"), at("down")]);
        let others = (0..count).filter(|&other| other != own);
        for other in others.clone() {
            let seen = format!("up {other}");
            let inputs = [at("p1"), at("up"), seen.clone()];
            let outputs = [at("p0"), at("down"), seen];
            net.transition(format!("withdraw {own} {other}"), inputs, outputs);
        }
        let down = others.map(|other| format!("down {other}"));
        let with = |place: String| down.clone().chain([place]).collect();
        net.transitions
            .push((at("enter"), with(at("p1")), with(at("p3"))));
    }
    net
}

/// Multiples are struck out by any of their divisors that is left.
pub fn eratosthenes(last: usize) -> Net {
    let mut net = Net::default();
    for number in 2..=last {
        net.place(number.to_string(), true);
    }
    for divisor in 2..=last {
        for multiple in (2 * divisor..=last).step_by(divisor) {
            let [kept, struck] = [divisor, multiple].map(|number| number.to_string());
            let name = format!("{multiple} by {divisor}");
            net.transition(name, [kept.clone(), struck], [kept]);
        }
    }
    net
}

/// Once it has begun, each votes for or against.
pub fn referendum(voters: usize) -> Net {
    let mut net = Net::default();
    net.place("ready".into(), true);
    let voting = (0..voters).map(|own| format!("voting {own}")).collect();
    net.transitions
        .push(("start".into(), vec!["ready".into()], voting));
    for own in 0..voters {
        let voting = format!("voting {own}");
        net.place(voting.clone(), false);
        for vote in ["yes", "no"] {
            net.place(format!("{vote} {own}"), false);
            net.transition(
                format!("votes {vote} {own}"),
                [voting.clone()],
                [format!("{vote} {own}")],
            );
        }
    }
    net
}
