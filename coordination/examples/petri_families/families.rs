//! The five scalable nets of Piedrafita and Villarroel (2011). Resources start marked, and each
//! process starts in its first state. What is given back is named first among the outputs.

use coordination::petri::NetModel;

/// A kind of net that grows with a number p.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// p independent cycles of two states.
    Seq,
    /// p processes of two states, the second of which needs the one resource.
    Pr1,
    /// One process that takes and gives back p resources in turn.
    P1r,
    /// p philosophers, who need two of p forks to eat.
    Ph,
    /// p processes that each take p − 1 resources one after another, then give all back at once.
    Square,
}

impl Family {
    pub const ALL: [Self; 5] = [Self::Seq, Self::Pr1, Self::P1r, Self::Ph, Self::Square];

    pub fn name(self) -> &'static str {
        match self {
            Self::Seq => "SEQ",
            Self::Pr1 => "PR1",
            Self::P1r => "P1R",
            Self::Ph => "PH",
            Self::Square => "SQUARE",
        }
    }

    /// The values of p that are measured.
    #[allow(dead_code, reason = "the benchmark has its own")]
    pub fn scales(self) -> &'static [usize] {
        match self {
            Self::Square => &[5, 10, 20, 50],
            _ => &[5, 10, 20, 50, 100],
        }
    }

    /// The net of scale p.
    pub fn model(self, p: usize) -> NetModel {
        let mut model = NetModel::new(format!("{}({p})", self.name()));
        let names = |prefix: &str| (0..p).map(|i| format!("{prefix}{i}")).collect::<Vec<_>>();
        let marked = |model: &mut NetModel, place: &str| {
            model.place(place).mark(place);
        };
        match self {
            Self::Seq => {
                for (idle, busy) in names("idle").iter().zip(&names("busy")) {
                    marked(&mut model, idle);
                    model.place(busy);
                    model.transition(format!("start {idle}"), &[idle], &[busy]);
                    model.transition(format!("end {idle}"), &[busy], &[idle]);
                }
            }
            Self::Pr1 => {
                marked(&mut model, "resource");
                for (idle, using) in names("idle").iter().zip(&names("using")) {
                    marked(&mut model, idle);
                    model.place(using);
                    model.transition(format!("take {idle}"), &[idle, "resource"], &[using]);
                    model.transition(format!("give {idle}"), &[using], &["resource", idle]);
                }
            }
            Self::P1r => {
                let (states, users, resources) =
                    (names("state"), names("using"), names("resource"));
                for i in 0..p {
                    model.place(&states[i]).place(&users[i]);
                    marked(&mut model, &resources[i]);
                }
                model.mark(&states[0]);
                for i in 0..p {
                    let (using, resource) = (&*users[i], &*resources[i]);
                    let next = &*states[(i + 1) % p];
                    model.transition(format!("take{i}"), &[&states[i], resource], &[using]);
                    model.transition(format!("give{i}"), &[using], &[resource, next]);
                }
            }
            Self::Ph => {
                let (thinking, eating, forks) = (names("think"), names("eat"), names("fork"));
                for i in 0..p {
                    marked(&mut model, &thinking[i]);
                    model.place(&eating[i]);
                    marked(&mut model, &forks[i]);
                }
                for i in 0..p {
                    let (think, eat) = (&*thinking[i], &*eating[i]);
                    let (left, right) = (&*forks[i], &*forks[(i + 1) % p]);
                    model.transition(format!("take{i}"), &[think, left, right], &[eat]);
                    model.transition(format!("give{i}"), &[eat], &[left, right, think]);
                }
            }
            Self::Square => {
                let resources = names("resource");
                for resource in &resources[1..] {
                    marked(&mut model, resource);
                }
                for process in 0..p {
                    let states = names(&format!("process{process} holds "));
                    for state in &states {
                        model.place(state);
                    }
                    model.mark(&states[0]);
                    for i in 1..p {
                        let name = format!("process{process} takes {i}");
                        model.transition(name, &[&states[i - 1], &resources[i]], &[&states[i]]);
                    }
                    let mut outputs: Vec<_> = resources[1..].iter().map(|r| &**r).collect();
                    outputs.push(&states[0]);
                    let name = format!("process{process} gives");
                    model.transition(name, &[&states[p - 1]], &outputs);
                }
            }
        }
        model
    }
}
