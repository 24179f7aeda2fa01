//! Coordination objects that come and go.

mod nets;

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use coordination::activity::{LifeCycleEvent, LifeCycleState};
use coordination::analysis::{Limits, Reason};
use coordination::event::EventTable;
use coordination::fsm::MachineModel;
use coordination::petri::{Binding, Budget, NetModel};
use coordination::protocol::{Change, End, FlagId, ProtocolModel, Side, channel};
use coordination::registration::{
    ConfigureError, Handle, Mechanism, MechanismError, Registry, RegistryError, SemanticId,
};
use nets::gate;

fn id(model: &str) -> SemanticId {
    SemanticId::new("petri_net", model)
}

fn ready<T>(registry: &mut Registry<T>, model: &str, object: T) -> Handle {
    let handle = registry.create(id(model), "area manager").unwrap();
    registry.configure(handle, |_| Ok::<_, ()>(object)).unwrap();
    handle
}

#[test]
fn a_registration_lives_through_its_life_cycle() {
    let mut registry = Registry::new(2);
    let handle = registry.create(id("a"), "area manager").unwrap();
    let state = |registry: &Registry<i32>| registry.get(handle).unwrap().state;
    assert_eq!(state(&registry), LifeCycleState::Created);
    assert_eq!(
        registry.run(handle),
        Err(RegistryError::NotNow {
            id: id("a"),
            state: LifeCycleState::Created,
            wanted: LifeCycleEvent::Run
        })
    );
    registry
        .configure(handle, |id| if id.model() == "a" { Ok(1) } else { Err(()) })
        .unwrap();
    assert_eq!(state(&registry), LifeCycleState::Ready);
    let not_running = registry.running(handle).unwrap_err();
    assert_eq!(
        not_running.to_string(),
        "`petri_net a` is ready, not running"
    );
    registry.run(handle).unwrap();
    *registry.running(handle).unwrap() += 1;
    assert_eq!(
        registry.delete(handle),
        Err(RegistryError::InUse { id: id("a") })
    );
    registry.pause(handle).unwrap();
    assert!(registry.running(handle).is_err());
    registry.run(handle).unwrap();
    registry
        .reconfigure(handle, |object| {
            *object *= 10;
            Ok::<_, ()>(())
        })
        .unwrap();
    assert_eq!(state(&registry), LifeCycleState::Ready);
    assert_eq!(registry.get(handle).unwrap().object, Some(&20));
    registry.stop(handle).unwrap();
    assert_eq!(registry.delete(handle), Ok(Some(20)));
    assert!(registry.is_empty());
}

#[test]
fn what_cannot_be_made_or_changed_can_be_configured_again() {
    let mut registry = Registry::new(1);
    let handle = registry.create(id("a"), "me").unwrap();
    assert_eq!(
        registry.configure(handle, |_| Err::<i32, _>("no memory")),
        Err(ConfigureError::Failed("no memory"))
    );
    let found = registry.get(handle).unwrap();
    assert_eq!(
        (found.state, found.object),
        (LifeCycleState::Configuring, None)
    );
    assert!(registry.run(handle).is_err());
    registry.configure(handle, |_| Ok::<_, ()>(1)).unwrap();
    registry.run(handle).unwrap();
    let failed = registry.reconfigure(handle, |_| Err("no such speed"));
    assert_eq!(failed, Err(ConfigureError::Failed("no such speed")));
    let found = registry.get(handle).unwrap();
    assert_eq!(
        (found.state, found.object),
        (LifeCycleState::Configuring, None)
    );
    registry.configure(handle, |_| Ok::<_, ()>(2)).unwrap();
    assert_eq!(registry.get(handle).unwrap().object, Some(&2));
    assert_eq!(registry.delete(handle), Ok(Some(2)));
}

#[test]
fn room_and_ids_are_limited_and_handles_go_stale() {
    let mut registry = Registry::new(2);
    let a = ready(&mut registry, "a", 'a');
    let b = ready(&mut registry, "b", 'b');
    assert_eq!(
        registry
            .create(id("a"), "somebody")
            .unwrap_err()
            .to_string(),
        "`petri_net a` is registered already, by `area manager`"
    );
    assert_eq!(
        registry
            .create(id("c"), "somebody")
            .unwrap_err()
            .to_string(),
        "no room for `petri_net c`: 2 are registered already"
    );
    assert_eq!(registry.delete(a), Ok(Some('a')));
    let c = ready(&mut registry, "c", 'c');
    // The place is used again, the handle is not.
    assert_ne!(a, c);
    let stale = RegistryError::Stale { handle: a };
    assert_eq!(registry.get(a).map(|_| ()), Err(stale.clone()));
    assert_eq!(registry.running(a).map(|_| ()), Err(stale.clone()));
    assert_eq!(registry.run(a), Err(stale.clone()));
    assert_eq!(registry.stop(a), Err(stale.clone()));
    assert_eq!(registry.delete(a), Err(stale.clone()));
    assert_eq!(
        registry.configure(a, |_| Ok::<_, ()>('x')),
        Err(ConfigureError::Registry(stale))
    );
    assert_eq!(registry.find(&id("a")), None);
    assert_eq!(
        (registry.find(&id("b")), registry.find(&id("c"))),
        (Some(b), Some(c))
    );
    let ids: Vec<_> = registry
        .iter()
        .map(|(handle, found)| (handle, found.id.model()))
        .collect();
    assert_eq!(ids, [(b, "b"), (c, "c")]);
    registry.run(c).unwrap();
    let running: Vec<_> = registry
        .iter_running()
        .map(|(handle, id, object)| (handle, id.model(), *object))
        .collect();
    assert_eq!(running, [(c, "c", 'c')]);
}

/// Counts how many of it exist.
struct Counted(Arc<AtomicUsize>);

impl Counted {
    fn new(alive: &Arc<AtomicUsize>) -> Self {
        alive.fetch_add(1, Ordering::Relaxed);
        Self(Arc::clone(alive))
    }
}

impl Drop for Counted {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

#[test]
fn dozens_come_and_go_and_leave_nothing_behind() {
    let alive = Arc::new(AtomicUsize::new(0));
    let mut registry = Registry::new(48);
    let mut handles = Vec::new();
    let mut gone = Vec::new();
    for round in 0..20_000_usize {
        if handles.len() == 48 || (round % 5 == 4 && !handles.is_empty()) {
            let handle = handles.swap_remove(round * 7 % handles.len());
            registry.stop(handle).unwrap();
            drop(registry.delete(handle).unwrap());
            gone.push(handle);
        } else {
            let name = format!("coordination {round}");
            let handle = ready(&mut registry, &name, Counted::new(&alive));
            registry.run(handle).unwrap();
            handles.push(handle);
        }
        assert_eq!(alive.load(Ordering::Relaxed), registry.len());
        assert!(registry.len() <= 48);
    }
    assert!(gone.len() > 4000);
    assert!(gone.iter().all(|&handle| registry.get(handle).is_err()));
    assert!(handles.iter().all(|&handle| registry.get(handle).is_ok()));
    drop(registry);
    assert_eq!(alive.load(Ordering::Relaxed), 0);
}

#[test]
fn a_net_that_the_analysis_refuses_never_runs() {
    let (mut model, uses) = gate(2);
    model
        .place("never")
        .transition("dead", &["never"], &["never"]);
    let mut events = EventTable::new();
    let mut registry = Registry::<Mechanism>::new(4);
    let handle = registry.create(id("gate"), "area manager").unwrap();
    let limits = Limits::default();
    let refused = registry
        .configure(handle, |_| {
            Mechanism::net(&model, &uses, &limits, &mut events).map(|(net, _)| net)
        })
        .unwrap_err();
    let ConfigureError::Failed(MechanismError::Refused(refusal)) = refused else {
        panic!("{refused}");
    };
    assert!(
        matches!(*refusal.reason, Reason::DeadTransitions { .. }),
        "{refusal}"
    );
    assert!(registry.run(handle).is_err() && registry.running(handle).is_err());

    let (model, uses) = gate(2);
    registry
        .configure(handle, |_| {
            Mechanism::net(&model, &uses, &limits, &mut events).map(|(net, _)| net)
        })
        .unwrap();
    registry.run(handle).unwrap();
    let Mechanism::Net(executor) = registry.running(handle).unwrap() else {
        panic!("it is a net");
    };
    executor.offer(events.id("r0.request").unwrap()).unwrap();
    assert_eq!(executor.evaluate(Budget::default()).fired, 1);
}

#[test]
fn machines_and_protocols_are_registered_alike() {
    let mut events = EventTable::new();
    let mut registry = Registry::<Mechanism>::new(4);
    let mut door = MachineModel::new("door");
    door.state("shut").state("open").initial("shut");
    door.transition("shut", "push", "open", &[]);
    let machine = registry
        .create(SemanticId::new("machine", "door"), "door")
        .unwrap();
    registry
        .configure(machine, |_| Mechanism::machine(&door, &mut events))
        .unwrap();
    registry.run(machine).unwrap();
    let Mechanism::Machine(running) = registry.running(machine).unwrap() else {
        panic!("it is a machine");
    };
    assert!(!running.step(events.id("push").unwrap()).ignored);

    let protocol = registry
        .create(SemanticId::new("protocol", "door"), "door")
        .unwrap();
    let empty = ProtocolModel::new("empty", "a", "b");
    let failed = registry
        .configure(protocol, |_| Mechanism::protocol(&empty))
        .unwrap_err();
    assert_eq!(failed.to_string(), "protocol `empty` has no arrays");
    let mut model = ProtocolModel::new("knock", "a", "b");
    model.array("all", &[("knock", "a"), ("come in", "b")]);
    registry
        .configure(protocol, |_| Mechanism::protocol(&model))
        .unwrap();
    let view = registry.get(protocol).unwrap();
    assert!(matches!(view.object, Some(Mechanism::Protocol(p)) if p.name() == "knock"));
}

/// A robot that sets its next flag when a coin says so.
struct Robot {
    side: End,
    crossed: u32,
}

impl Robot {
    fn turn(&mut self) {
        while let Some(change) = self.side.poll() {
            assert!(matches!(change, Change::Flag(_)));
        }
        let next = self.side.protocol().next(self.side.position()).next();
        let flag: Option<FlagId> = next.map(|(flag, _)| flag);
        if let Some(flag) = flag
            && self.side.set(flag).is_ok()
            && self.side.protocol().flag_name(flag) == "released"
        {
            self.crossed += 1;
        }
    }
}

#[test]
fn coordinations_run_side_by_side_and_are_deleted_at_their_end() {
    const CROSSINGS: u32 = 5;
    let mut events = EventTable::new();
    let mut registry = Registry::<Mechanism>::new(36);
    let mut robots: Vec<(Handle, Vec<Robot>)> = Vec::new();
    for number in 0..36 {
        let (model, uses) = gate(1 + number % 3);
        let name = format!("gate {number}");
        let handle = registry.create(id(&name), "area manager").unwrap();
        let mut sides = Vec::new();
        let mut own = Vec::new();
        for used in &uses {
            let (robot, mediator) = channel(&used.protocol);
            sides.push((used.name.as_str().into(), mediator));
            own.push(Robot {
                side: robot,
                crossed: 0,
            });
        }
        registry
            .configure(handle, |_| {
                let limits = Limits::default();
                Mechanism::coordination(&model, sides, &limits, &mut events).map(|(net, _)| net)
            })
            .unwrap();
        registry.run(handle).unwrap();
        robots.push((handle, own));
    }
    let mut coin = 0x1234_5678_9ABC_DEF1_u64;
    for _ in 0..100_000 {
        if registry.is_empty() {
            return;
        }
        for (_, own) in &mut robots {
            for robot in own.iter_mut().filter(|robot| robot.crossed < CROSSINGS) {
                coin ^= coin << 13;
                coin ^= coin >> 7;
                coin ^= coin << 17;
                if coin.is_multiple_of(3) {
                    robot.turn();
                }
            }
        }
        for (_, _, mechanism) in registry.iter_running() {
            let Mechanism::Coordination(net) = mechanism else {
                panic!("only coordinations are registered");
            };
            net.step(Budget::default(), |_| true);
        }
        robots.retain(|(handle, own)| {
            let Some(Mechanism::Coordination(net)) = registry.get(*handle).unwrap().object else {
                panic!("it has been configured");
            };
            let net = net.executor();
            let idle = net
                .marking()
                .map(|place| net.net().place_name(place))
                .eq(["free"]);
            let done = own.iter().all(|robot| robot.crossed == CROSSINGS) && idle;
            if done {
                registry.stop(*handle).unwrap();
                assert!(registry.delete(*handle).unwrap().is_some());
            }
            !done
        });
    }
    panic!("{} coordinations did not come to their end", registry.len());
}

#[test]
fn a_net_that_does_not_fit_its_protocols_is_refused() {
    let (mut model, uses) = gate(1);
    model.source("odd", Binding::flag("r0", "asked"));
    model.transition("odd one", &["odd"], &[]);
    let (_, mediator) = channel(&uses[0].protocol);
    let mut events = EventTable::new();
    let sides = vec![("r0".into(), mediator)];
    let refused = Mechanism::coordination(&model, sides, &Limits::default(), &mut events);
    let text = refused.map(|_| ()).unwrap_err().to_string();
    assert!(text.contains("unknown flag `asked`"), "{text}");
    let empty = NetModel::new("empty");
    let refused = Mechanism::<End>::net(&empty, &[], &Limits::default(), &mut events);
    assert!(
        refused
            .map(|_| ())
            .unwrap_err()
            .to_string()
            .contains("no transitions")
    );
}
