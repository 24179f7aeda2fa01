//! The pattern by which resources are acquired and released, through its two roles.

use coordination::acquire_release::{
    AcquireRelease, By, Owner, PatternError, Phase, Resource, Revocation, RoleError, User,
    WrongSide,
};
use coordination::protocol::{
    AbortError, Change, End, Party, Position, ProtocolModel, Replica, SetError, Side, channel,
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

fn roles<'a>(resource: &'a Resource, ends: &'a mut (End, End)) -> (User<'a, End>, Owner<'a, End>) {
    let user = User::new(resource, &mut ends.0).unwrap();
    (user, Owner::new(resource, &mut ends.1).unwrap())
}

#[test]
fn a_resource_is_asked_for_used_and_released() {
    let resource = full();
    let flag = |name| resource.protocol().flag(name).unwrap();
    let mut ends = channel(resource.protocol());
    let (mut user, mut owner) = roles(&resource, &mut ends);
    assert!(user.may_request() && !owner.may_grant() && !user.may_release());
    user.request().unwrap();
    assert!(!owner.may_grant(), "the request was not read");
    assert_eq!(owner.read(|_| {}), Phase::Wanted);
    assert!(owner.may_grant() && owner.may_refuse() && !owner.may_confirm());
    owner.grant().unwrap();
    assert_eq!(user.read(|_| {}), Phase::Held);
    assert!(user.may_give_back() && !user.may_release() && user.may_step(flag("taken")));
    user.step(flag("taken")).unwrap();
    assert!(!user.may_give_back(), "it is in use");
    owner.read(|_| {});
    assert!(!user.may_step(flag("checked")), "it is the owner's");
    owner.step(flag("checked")).unwrap();
    user.read(|_| {});
    assert!(user.may_release());
    user.release().unwrap();
    assert_eq!(user.phase(), Phase::Releasing);
    assert_eq!(owner.read(|_| {}), Phase::Releasing);
    assert!(owner.may_confirm());
    owner.confirm().unwrap();
    assert_eq!(owner.phase(), Phase::Over);
    assert_eq!(
        user.read(|_| {}),
        Phase::Free,
        "reading the last flag empties the array"
    );
    assert!(user.may_request());
}

#[test]
fn a_step_of_the_use_is_nothing_else() {
    let mut model = AcquireRelease::new("room", "robot", "door");
    model.acquire("ask", "granted").refuse("refused");
    model.release("left").confirm("seen").give_back("unused");
    let resource = model.compile().unwrap();
    let flag = |name| resource.protocol().flag(name).unwrap();
    let mut ends = channel(resource.protocol());
    let (mut user, mut owner) = roles(&resource, &mut ends);
    let refused = |name| Err(RoleError::NotOfUse(flag(name)));
    assert!(!user.may_step(flag("ask")));
    assert_eq!(user.step(flag("ask")), refused("ask"));
    user.request().unwrap();
    owner.read(|_| {});
    for name in ["granted", "refused"] {
        assert_eq!(owner.step(flag(name)), refused(name));
    }
    owner.grant().unwrap();
    user.read(|_| {});
    for name in ["left", "unused"] {
        assert!(!user.may_step(flag(name)));
        assert_eq!(user.step(flag(name)), refused(name));
    }
    user.release().unwrap();
    owner.read(|_| {});
    assert_eq!(owner.step(flag("seen")), refused("seen"));
    assert_eq!(owner.phase(), Phase::Releasing);
}

#[test]
fn a_resource_is_refused_given_back_or_taken_away() {
    let resource = full();
    let mut ends = channel(resource.protocol());
    let (mut user, mut owner) = roles(&resource, &mut ends);
    user.request().unwrap();
    owner.read(|_| {});
    owner.refuse().unwrap();
    assert_eq!(user.read(|_| {}), Phase::Free);

    user.request().unwrap();
    owner.read(|_| {});
    owner.grant().unwrap();
    user.read(|_| {});
    user.give_back().unwrap();
    assert_eq!(owner.read(|_| {}), Phase::Free);

    user.request().unwrap();
    owner.read(|_| {});
    owner.grant().unwrap();
    owner.take_away().unwrap();
    let mut read = Vec::new();
    assert_eq!(user.read(|change| read.push(change)), Phase::Free);
    assert_eq!(read, [Change::Aborted]);
}

#[test]
fn what_is_not_declared_or_not_next_is_refused_and_changes_nothing() {
    let mut model = AcquireRelease::new("room", "robot", "door");
    model.acquire("ask", "granted").release("left");
    let resource = model.compile().unwrap();
    let mut ends = channel(resource.protocol());
    let (mut user, mut owner) = roles(&resource, &mut ends);
    let error = user.give_back().unwrap_err();
    assert_eq!(
        error.to_string(),
        "the protocol of the resource has no flag that says `give back`"
    );
    assert!(matches!(
        user.release(),
        Err(RoleError::Set(SetError::OutOfOrder { .. }))
    ));
    assert!(matches!(
        owner.grant(),
        Err(RoleError::Set(SetError::OutOfOrder { .. }))
    ));
    assert_eq!(owner.take_away(), Err(AbortError::NotKeeper));
    assert_eq!((user.phase(), owner.phase()), (Phase::Free, Phase::Free));
    assert!(matches!(
        User::new(&resource, &mut ends.1),
        Err(WrongSide::Party)
    ));
    assert!(matches!(
        Owner::new(&full(), &mut ends.1),
        Err(WrongSide::Protocol)
    ));
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
    User::new(&resource, &mut mediator)
        .unwrap()
        .request()
        .unwrap();
    robot.merge(mediator.level()).unwrap();
    let mut owner = Owner::new(&resource, &mut robot).unwrap();
    owner.read(|_| {});
    owner.grant().unwrap();
    mediator.merge(robot.level()).unwrap();
    let mut user = User::new(&resource, &mut mediator).unwrap();
    assert_eq!(user.read(|_| {}), Phase::Held);
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
