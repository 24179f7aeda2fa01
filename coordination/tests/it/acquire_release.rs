//! The pattern by which resources are acquired and released, run on two sides.

use std::sync::Arc;

use coordination::acquire_release::{
    AcquireRelease, By, PatternError, Phase, Resource, Revocation,
};
use coordination::protocol::{
    AbortError, Change, Party, Position, Protocol, ProtocolModel, Replica, SetError, Side, channel,
};

fn full() -> Resource {
    let mut model = AcquireRelease::new("tool", "arm", "rack");
    model
        .keeper(By::Owner)
        .acquire("ask", "granted")
        .refuse("refused");
    model.using("taken", By::User).using("checked", By::Owner);
    model.release("back").confirm("seen").give_back("unused");
    model.compile().unwrap()
}

/// Sets a flag on one side, reads it on the other, and says where the resource is then.
fn say(resource: &Resource, name: &str, from: &mut impl Side, to: &mut impl Side) -> Phase {
    let flag = resource.protocol().flag(name).unwrap();
    from.set(flag).unwrap();
    assert_eq!(to.poll(), Some(Change::Flag(flag)));
    resource.phase(to.read_to())
}

#[test]
fn a_resource_is_asked_for_used_and_released() {
    let resource = full();
    let (mut user, mut owner) = channel(resource.protocol());
    assert_eq!(resource.phase(user.read_to()), Phase::Free);
    let asked = say(&resource, "ask", &mut user, &mut owner);
    let held = say(&resource, "granted", &mut owner, &mut user);
    let used = say(&resource, "taken", &mut user, &mut owner);
    let checked = say(&resource, "checked", &mut owner, &mut user);
    let released = say(&resource, "back", &mut user, &mut owner);
    assert_eq!(resource.phase(user.read_to()), Phase::Releasing);
    // Who reads the last flag empties the array.
    let confirmed = say(&resource, "seen", &mut owner, &mut user);
    let expected = [
        Phase::Wanted,
        Phase::Held,
        Phase::Held,
        Phase::Held,
        Phase::Releasing,
        Phase::Free,
    ];
    assert_eq!([asked, held, used, checked, released, confirmed], expected);
}

#[test]
fn a_resource_is_refused_given_back_or_taken_away() {
    let resource = full();
    let (mut user, mut owner) = channel(resource.protocol());
    say(&resource, "ask", &mut user, &mut owner);
    let refused = say(&resource, "refused", &mut owner, &mut user);
    assert_eq!(refused, Phase::Free);

    say(&resource, "ask", &mut user, &mut owner);
    say(&resource, "granted", &mut owner, &mut user);
    let unused = say(&resource, "unused", &mut user, &mut owner);
    assert_eq!(unused, Phase::Free);

    say(&resource, "ask", &mut user, &mut owner);
    say(&resource, "granted", &mut owner, &mut user);
    owner.abort().unwrap();
    assert_eq!(user.poll(), Some(Change::Aborted));
    assert_eq!(resource.phase(user.read_to()), Phase::Free);
}

/// It may be given back unused only before it is used, and released only behind the steps of its use.
#[test]
fn what_is_not_declared_or_not_next_is_refused_and_changes_nothing() {
    let resource = full();
    let flag = |name| resource.protocol().flag(name).unwrap();
    let (mut user, mut owner) = channel(resource.protocol());
    let is_not_next = |result| matches!(result, Err(SetError::OutOfOrder { .. }));
    assert!(is_not_next(user.set(flag("back"))) && is_not_next(owner.set(flag("granted"))));
    say(&resource, "ask", &mut user, &mut owner);
    say(&resource, "granted", &mut owner, &mut user);
    assert!(is_not_next(user.set(flag("back"))), "it was not used");
    say(&resource, "taken", &mut user, &mut owner);
    assert!(is_not_next(user.set(flag("unused"))), "it is in use");
    assert_eq!(resource.phase(owner.read_to()), Phase::Held);

    let mut model = AcquireRelease::new("room", "robot", "door");
    model.acquire("ask", "granted").release("left");
    let resource = model.compile().unwrap();
    let (_, mut owner) = channel(resource.protocol());
    assert_eq!(resource.protocol().flag("unused"), None);
    assert_eq!(owner.abort(), Err(AbortError::NotKeeper));
}

#[test]
fn a_declaration_without_acquire_or_release_is_refused() {
    let mut model = AcquireRelease::new("room", "robot", "door");
    assert_eq!(
        model.compile().unwrap_err(),
        PatternError::NoAcquire("room".to_owned())
    );
    model.acquire("ask", "granted");
    assert_eq!(
        model.compile().unwrap_err(),
        PatternError::NoRelease("room".to_owned())
    );
    model.release("ask");
    assert!(model.compile().unwrap_err().to_string().contains("`ask`"));
}

#[test]
fn every_position_is_one_phase_and_turns_follow_it() {
    let resource = full();
    let protocol = resource.protocol();
    for at in protocol.positions() {
        let phase = resource.phase(at);
        assert_eq!(phase == Phase::Free, at == Position::START);
        assert_eq!(phase == Phase::Over, protocol.is_end(at));
        let turn = protocol.turn(at);
        match phase {
            Phase::Free => assert_eq!(turn, Some(resource.user())),
            Phase::Wanted | Phase::Releasing => assert_eq!(turn, Some(resource.user().other())),
            Phase::Held => assert!(turn.is_some()),
            Phase::Over => assert_eq!(turn, None),
        }
    }
}

#[test]
fn the_owner_may_be_the_first_party_and_on_another_machine() {
    let mut model = AcquireRelease::new("control", "mediator", "robot");
    model
        .owner_first()
        .acquire("acquire", "acquired")
        .release("release")
        .confirm("released");
    let resource = model.compile().unwrap();
    assert_eq!(resource.user(), Party::Second);
    let side = |party| Replica::new(resource.protocol(), 1, party, 0);
    let (mut robot, mut mediator) = (side(Party::First), side(Party::Second));
    let flag = |name| resource.protocol().flag(name).unwrap();
    mediator.set(flag("acquire")).unwrap();
    robot.merge(mediator.level()).unwrap();
    assert_eq!(robot.poll(), Some(Change::Flag(flag("acquire"))));
    robot.set(flag("acquired")).unwrap();
    mediator.merge(robot.level()).unwrap();
    assert_eq!(mediator.poll(), Some(Change::Flag(flag("acquired"))));
    assert_eq!(resource.phase(mediator.read_to()), Phase::Held);
    assert!(resource.is_held(mediator.position()));
}

#[test]
fn an_owner_asks_for_it_back() {
    let model = ProtocolModel::new("revocation", "robot", "mediator");
    let flags = ["revoke", "yielded", "kept"];
    let revocation = Revocation::compile(model, "robot", "mediator", flags).unwrap();
    let (mut robot, mut mediator) = channel(&revocation.protocol);
    mediator.set(revocation.revoke).unwrap();
    assert_eq!(robot.poll(), Some(Change::Flag(revocation.revoke)));
    robot.set(revocation.kept).unwrap();
    assert_eq!(mediator.poll(), Some(Change::Flag(revocation.kept)));
}

#[test]
fn a_protocol_with_branches_is_one_if_each_of_its_paths_acquires_and_releases() {
    let branches = |last: &[(&str, &str)]| {
        let mut model = ProtocolModel::new("control", "robot", "mediator");
        model.array("take", &[("acquire", "mediator"), ("acquired", "robot")]);
        model
            .array("wait", &[("wait", "mediator")])
            .array("leave", &[("leave", "mediator")])
            .array("free", last);
        for step in ["wait", "leave"] {
            model.follow("take", step).follow(step, "free");
        }
        Arc::new(model.compile().unwrap())
    };
    let of = |protocol: &Arc<Protocol>| {
        Resource::of(
            protocol,
            Party::Second,
            ["acquire", "acquired"],
            ["release", "released"],
        )
    };
    let protocol = branches(&[("release", "mediator"), ("released", "robot")]);
    let control = of(&protocol).unwrap();
    assert_eq!(control.user(), Party::Second);
    for at in protocol.positions() {
        let set = |name: &str| {
            let flag = protocol.flag(name);
            protocol.set_flags(at).any(|(own, _)| Some(own) == flag)
        };
        assert_eq!(control.is_held(at), set("acquired") && !set("release"));
    }
    // The robot never says that it is free; or says it for the mediator.
    for last in [
        &[("release", "mediator")][..],
        &[("release", "mediator"), ("released", "mediator")],
        &[("release", "robot"), ("released", "robot")],
    ] {
        let protocol = branches(last);
        let error = of(&protocol).unwrap_err();
        assert!(protocol.is_end(error.end));
    }
}
