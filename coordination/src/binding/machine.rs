//! The robot's half: a state machine and the protocols that it takes part in.

use std::collections::VecDeque;

use thiserror::Error;

use super::error::{BindError, Named, Role, duplicates, find_flag, longest_run};
use crate::event::EventId;
use crate::fsm::{Machine, StateId};
use crate::protocol::{Change, FlagId, SetError, Side};

/// The queues of flags that wait to be set might overflow. The machine did not step; the event comes
/// back.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("event {} has to wait: too many output flags are waiting to be set", .0.0)]
pub struct NoRoom(pub EventId);

/// A flag that the machine fired and its protocol does not take: the machine and the protocol
/// disagree about the order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stuck<'a> {
    /// The name of the protocol.
    pub protocol: &'a str,
    /// The flag.
    pub flag: FlagId,
    /// Why it is not taken.
    pub error: SetError,
}

/// One protocol and what the machine is bound to there.
#[derive(Debug)]
struct Port<S> {
    name: Box<str>,
    side: S,
    /// By flag: the machine's input.
    incoming: Box<[Option<EventId>]>,
    aborted: Option<EventId>,
    /// An abort was read, and the machine has not stepped for it yet.
    abort_due: bool,
    /// Flags that the machine fired, in order.
    to_set: VecDeque<FlagId>,
    /// How many of them there may be.
    room: usize,
    /// The most that one step of the machine fires.
    most_fired: usize,
    longest_run: u16,
    refusal: Option<SetError>,
    voided: u64,
}

/// What asks for room.
#[derive(Clone, Copy, Debug)]
enum Room {
    Event,
    Abort,
}

/// An output of the machine that is a flag.
#[derive(Clone, Copy, Debug)]
struct Outgoing {
    port: u16,
    flag: FlagId,
}

/// A machine whose inputs and outputs are flags of protocols; see [the module](super).
#[derive(Debug)]
pub struct MachineBinding<S> {
    machine: Machine,
    ports: Box<[Port<S>]>,
    /// By event, as far as outputs are flags.
    outgoing: Box<[Option<Outgoing>]>,
}

impl<S: Side> MachineBinding<S> {
    /// Binds a machine to protocols: inputs and outputs of the machine that are called
    /// `<protocol>.<flag>`, with a name given here in front, are flags; all others are events. An output
    /// with a dot in its name and no protocol of that name would be a flag that nobody ever sees.
    ///
    /// # Errors
    /// All that does not fit.
    pub fn new<N: Into<Box<str>>>(
        machine: Machine,
        sides: impl IntoIterator<Item = (N, S)>,
    ) -> Result<Self, Vec<BindError>> {
        let mut ports: Box<[Port<S>]> = sides
            .into_iter()
            .map(|(name, side)| Port::new(name.into(), side))
            .collect();
        let mut errors = duplicates(ports.iter().map(|port| &*port.name));
        for (event, name) in machine.inputs() {
            let user = || format!("input `{name}` of machine `{}`", machine.name());
            match find(&ports, user, Role::Reads, name) {
                Some(Ok((port, Named::Flag(flag)))) => {
                    ports[port].incoming[flag.index()] = Some(event);
                }
                Some(Ok((port, Named::Abort))) => ports[port].aborted = Some(event),
                Some(Err(error)) => errors.push(error),
                None => {}
            }
        }
        let mut outgoing = Vec::new();
        for (event, name) in machine.outputs() {
            let user = || format!("output `{name}` of machine `{}`", machine.name());
            match find(&ports, user, Role::Sets, name) {
                Some(Ok((port, Named::Flag(flag)))) => {
                    if outgoing.len() <= event.index() {
                        outgoing.resize(event.index() + 1, None);
                    }
                    let port = port as u16;
                    outgoing[event.index()] = Some(Outgoing { port, flag });
                }
                // A run is aborted by its keeper, not by an output.
                Some(Ok((_, Named::Abort))) => {}
                Some(Err(error)) => errors.push(error),
                None => errors.extend(name.rsplit_once('.').map(|(protocol, _)| {
                    let known: Vec<_> = ports.iter().map(|port| &*port.name).collect();
                    BindError::UnknownProtocol {
                        user: user(),
                        protocol: protocol.to_owned(),
                        known: known.join(", "),
                    }
                })),
            }
        }
        if !errors.is_empty() {
            return Err(errors);
        }
        let mut binding = Self {
            machine,
            ports,
            outgoing: outgoing.into(),
        };
        binding.make_room();
        Ok(binding)
    }

    /// Sets what waits to be set, reads what the other parties did, and steps the machine for each
    /// of their flags that its present state has a transition for. Outputs that are no flags go to
    /// `fire`. Returns how many flags were read. Real time if `fire` is.
    pub fn communicate(&mut self, mut fire: impl FnMut(EventId)) -> u32 {
        let mut read = 0;
        self.set_flags();
        for number in 0..self.ports.len() {
            for _ in 0..self.ports[number].longest_run {
                if !self.read(number, &mut fire) {
                    break;
                }
                read += 1;
            }
        }
        read
    }

    /// Steps the machine for an event that is no flag. Flags that it fires are set, or wait for
    /// their turn; all other outputs go to `fire`. Real time if `fire` is.
    ///
    /// # Errors
    /// [`NoRoom`] while outputs of earlier steps wait; the machine has not moved.
    pub fn step(&mut self, event: EventId, fire: impl FnMut(EventId)) -> Result<(), NoRoom> {
        if !self.has_room(Room::Event) {
            return Err(NoRoom(event));
        }
        self.run(event, fire);
        Ok(())
    }

    /// The machine.
    #[must_use]
    pub fn machine(&self) -> &Machine {
        &self.machine
    }

    /// The name of the machine's present state.
    #[must_use]
    pub fn state_name(&self) -> &str {
        self.machine.state_name(self.machine.state())
    }

    /// Continues in `state`, without firing anything; `false`, and no change, if the machine has no
    /// such state.
    pub fn restart_in(&mut self, state: StateId) -> bool {
        self.machine.restart_in(state)
    }

    /// This party's side of the protocol called `name`. Searches.
    #[must_use]
    pub fn side(&self, name: &str) -> Option<&S> {
        let port = self.ports.iter().find(|port| *port.name == *name)?;
        Some(&port.side)
    }

    /// As [`side`](Self::side), to merge levels into it. Flags are set by the machine.
    pub fn side_mut(&mut self, name: &str) -> Option<&mut S> {
        let port = self.ports.iter_mut().find(|port| *port.name == *name)?;
        Some(&mut port.side)
    }

    /// How many flags of the protocol called `name` the machine fired that wait for their turn.
    #[must_use]
    pub fn waiting(&self, name: &str) -> usize {
        let port = self.ports.iter().find(|port| *port.name == *name);
        port.map_or(0, |port| port.to_set.len())
    }

    /// Flags that can never be set, because it is this party's turn and the protocol expects
    /// another one. They stay, and so does the protocol, until its run is aborted.
    pub fn stuck(&self) -> impl Iterator<Item = Stuck<'_>> {
        self.ports.iter().filter_map(|port| {
            let (flag, error) = (*port.to_set.front()?, port.refusal?);
            let SetError::OutOfOrder { at, .. } = error else {
                return None;
            };
            let mine = port.side.protocol().turn(at) == Some(port.side.party());
            mine.then_some(Stuck {
                protocol: &port.name,
                flag,
                error,
            })
        })
    }

    /// How many flags that waited to be set were voided because the other party aborted their run.
    #[must_use]
    pub fn voided(&self) -> u64 {
        self.ports.iter().map(|port| port.voided).sum()
    }

    /// Reads one change of a protocol; `false` if there is none, or if it has to wait.
    fn read(&mut self, number: usize, fire: &mut impl FnMut(EventId)) -> bool {
        let port = &self.ports[number];
        if port.abort_due {
            return self.read_abort(number, fire);
        }
        match port.side.peek() {
            None => false,
            Some(Change::Aborted) => self.read_abort(number, fire),
            Some(Change::Flag(flag)) => {
                let accepts = |event| self.has_room(Room::Event) && self.machine.accepts(event);
                if !port.incoming[flag.index()].is_none_or(accepts) {
                    return false;
                }
                match self.ports[number].side.poll() {
                    None => false,
                    Some(Change::Flag(flag)) => {
                        if let Some(event) = self.ports[number].incoming[flag.index()] {
                            self.run(event, fire);
                        }
                        true
                    }
                    Some(Change::Aborted) => {
                        // The keeper was quicker: the flag is void.
                        self.ports[number].abort_due = true;
                        self.read_abort(number, fire)
                    }
                }
            }
        }
    }

    /// Steps the machine for an abort, which stays unread, or due, while there is no room.
    fn read_abort(&mut self, number: usize, fire: &mut impl FnMut(EventId)) -> bool {
        // What waited here is void, so there is room, at least here.
        let port = &mut self.ports[number];
        port.voided += port.to_set.len() as u64;
        port.to_set.clear();
        port.refusal = None;
        let event = port.aborted;
        if event.is_some() && !self.has_room(Room::Abort) {
            return false;
        }
        let port = &mut self.ports[number];
        if !std::mem::take(&mut port.abort_due) {
            port.side.poll();
        }
        if let Some(event) = event {
            self.run(event, fire);
        }
        true
    }

    /// Steps the machine, for whose flags there is room.
    fn run(&mut self, event: EventId, mut fire: impl FnMut(EventId)) {
        for &output in self.machine.step(event).outputs {
            match self.outgoing.get(output.index()).copied().flatten() {
                Some(Outgoing { port, flag }) => {
                    self.ports[usize::from(port)].to_set.push_back(flag);
                }
                None => fire(output),
            }
        }
        self.set_flags();
    }

    fn set_flags(&mut self) {
        for port in &mut self.ports {
            // What is fired while an abort is due belongs to the run that is over.
            while !port.abort_due
                && let Some(&flag) = port.to_set.front()
            {
                port.refusal = port.side.set(flag).err();
                if port.refusal.is_some() {
                    break;
                }
                port.to_set.pop_front();
            }
        }
    }

    /// Whether what one step fires finds room. Aborts have room of their own, so that they do not
    /// have to wait for another protocol.
    fn has_room(&self, room: Room) -> bool {
        let steps = match room {
            Room::Event => 1 + self.ports.len(),
            Room::Abort => 1,
        };
        let mut ports = self.ports.iter();
        ports.all(|port| port.room - port.to_set.len() >= steps * port.most_fired)
    }

    /// Makes room for the flags of the present run and of one that begins early, for all that one
    /// step fires, and for one abort of each protocol.
    fn make_room(&mut self) {
        for transition in self.machine.transitions() {
            for (number, port) in self.ports.iter_mut().enumerate() {
                let fired = transition.outputs.iter().filter(|output| {
                    let outgoing = self.outgoing.get(output.index()).copied().flatten();
                    outgoing.is_some_and(|outgoing| usize::from(outgoing.port) == number)
                });
                port.most_fired = port.most_fired.max(fired.count());
            }
        }
        let steps = 1 + self.ports.len();
        for port in &mut self.ports {
            port.room = steps * port.most_fired + 2 * usize::from(port.longest_run);
            port.to_set.reserve_exact(port.room);
        }
    }
}

impl<S: Side> Port<S> {
    fn new(name: Box<str>, side: S) -> Self {
        let flags = side.protocol().flags().count();
        Self {
            name,
            incoming: vec![None; flags].into(),
            aborted: None,
            abort_due: false,
            to_set: VecDeque::new(),
            room: 0,
            most_fired: 0,
            longest_run: longest_run(side.protocol()),
            refusal: None,
            voided: 0,
            side,
        }
    }
}

/// What `name` is, if it begins with a protocol's name and a dot.
fn find<S: Side>(
    ports: &[Port<S>],
    user: impl Fn() -> String,
    role: Role,
    name: &str,
) -> Option<Result<(usize, Named), BindError>> {
    let ports = ports.iter().enumerate();
    let prefixed = ports.filter_map(|(number, port)| {
        let flag = name.strip_prefix(&*port.name)?.strip_prefix('.')?;
        Some((number, port, flag))
    });
    // One protocol's name can be the beginning of another's.
    let (number, port, flag) = prefixed.min_by_key(|(_, _, flag)| flag.len())?;
    let protocol = (&*port.name, port.side.protocol());
    let named = find_flag(user, protocol, port.side.party(), role, flag);
    Some(named.map(|named| (number, named)))
}
