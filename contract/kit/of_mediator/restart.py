"""What a mediator that has started says and believes. These checks start and kill it."""

from __future__ import annotations

import time
from typing import Any

from .. import page
from ..checks import Failed
from ..fleet import STARTS_S, Fleet, at_progress, found, holds
from ..played_robot import Claim, Heard, PlayedRobot
from . import SUITE

WAITS = ("A mediator that has started grants nothing until every robot of its site has said where it stands (`located`), or an operator "
         "that it is absent.")
INSTANCE = "Each process of one draws an `instance` when it starts, and each journal's file has a `journal`, drawn when it began"
BELIEVED = ("A robot is believed to have a grant that the mediator does not know of only in its first report after a start of the "
            "mediator, as long as that grants nothing, and only with a larger fence than the journal knows.")
BODY = ("A process that its journal does not know speaks for the robot's body only 5 s after that start, in a report that names a message sent "
        "then or later")
SESSIONS = ("| `session` | a million times the `mediator_epoch`, and 1 | with every process of that robot to which one is offered, a million times "
            "in an epoch | 2^62 |")


def meet(fleet: Fleet, robot: PlayedRobot, epoch: int = 0) -> Any:
    """The first message of a mediator with a larger epoch."""
    return fleet.expect(robot, STARTS_S + fleet.settings.margin_s, lambda heard: heard.message.mediator_epoch > epoch,
                        f"a message of the restarted mediator, with an epoch above {epoch}")


def started(fleet: Fleet, anew: bool) -> list[PlayedRobot]:
    """The mediator restarted, and a process of each robot that does not speak yet."""
    fleet.restart(anew=anew)
    fleet.robots = [fleet.process(robot_id, speaks=False) for robot_id in fleet.settings.robots]
    return fleet.robots


@SUITE.check("epoch-grows", "its own `mediator_epoch`, which grows at least with every start of a mediator", INSTANCE, needs=["--start"])
def epoch_grows(fleet: Fleet) -> None:
    """A restart on the same journal has a larger epoch, another instance and the same journal."""
    robot = fleet.robots[0]
    before = robot.messages[-1].message
    fleet.restart(go_on=True)
    after = fleet.expect(robot, STARTS_S + fleet.settings.margin_s, lambda heard: heard.message.instance != before.instance,
                         "a message of another instance").message
    if after.mediator_epoch <= before.mediator_epoch:
        raise Failed(f"an epoch above {before.mediator_epoch}", str(after.mediator_epoch))
    if 0 in (after.instance, before.instance) or after.journal != before.journal:
        raise Failed("another instance, not 0, and the same journal",
                     f"instance {before.instance} and then {after.instance}, journal {before.journal} and then {after.journal}")


@SUITE.check("instance-constant", INSTANCE)
def instance_constant(fleet: Fleet) -> None:
    """Within one process instance and journal never change, and are not 0."""
    time.sleep(page.SILENT_S)
    said = {(heard.message.instance, heard.message.journal) for robot in fleet.robots for heard in robot.messages}
    if len(said) != 1 or 0 in next(iter(said)):
        raise Failed("one instance and one journal in all messages, not 0", f"{said}")


@SUITE.check("grants-survive", "go on with the levels that are there, under the new number.", needs=["--start", "2 robots"])
def grants_survive(fleet: Fleet) -> None:
    """After a kill and a restart the robot still has its area, with the same fence, and nobody else gets it."""
    first, second = fleet.robots[:2]
    area, = fleet.areas(1)
    claim = fleet.obtain(first, area)
    first.enter(area)
    fleet.expect(first, fleet.soon_s, at_progress(area, claim.run, 3), f"{area} entered")
    epoch = first.mediator_epoch
    fleet.restart(go_on=True)
    meet(fleet, first, epoch)
    for robot in fleet.robots:
        fleet.expect(robot, STARTS_S, lambda heard: heard.message.mediator_epoch > epoch and heard.message.session != 0, "registration")
    second.request(area)
    fleet.refused(second, area, f"{first.robot_id} is in it")
    fleet.expect(first, fleet.soon_s, lambda heard: heard.access(area) == claim.then(3), f"level {claim.then(3)}")


@SUITE.check("fence-outlives-restart", "The grant's `fence` grows with every grant of that area.", needs=["--start"])
def fence_outlives_restart(fleet: Fleet) -> None:
    """The first grant of an area after a restart has a larger fence than the last one before."""
    robot, (area,) = fleet.robots[0], fleet.areas(1)
    claim = fleet.obtain(robot, area)
    robot.give_back(area)
    fleet.expect(robot, fleet.soon_s, at_progress(area, claim.run + 1, 0), f"{area} emptied")
    epoch = robot.mediator_epoch
    fleet.restart(go_on=True)
    for other in fleet.robots:
        meet(fleet, other, epoch)
    robot.request(area)
    heard = fleet.expect(robot, fleet.taken_in_s, holds(area), f"a grant of {area}")
    after = heard.access(area)
    if after is None or after.fence <= claim.fence:
        raise Failed(f"a fence above {claim.fence}", f"{after}")


def claims_after_start(fleet: Fleet, more: int) -> tuple[str, PlayedRobot, PlayedRobot, Claim]:
    """A restart on the same journal, and a robot that claims a grant with a fence so much above the journal's."""
    area, = fleet.areas(1)
    claim = fleet.obtain(fleet.robots[0], area)
    fleet.robots[0].give_back(area)
    emptied = at_progress(area, claim.run + 1, 0)
    fleet.expect(fleet.robots[0], fleet.soon_s, emptied, f"{area} emptied")
    first, epoch = fleet.robots[0], fleet.robots[0].mediator_epoch
    for robot in fleet.robots[1:]:
        robot.speaks = False
    assert fleet.program is not None
    fleet.program.kill()
    with first.lock:
        lied = Claim(claim.run + 1, 0, 3, claim.fence + more)
        first.claims[area], first.stands_in = lied, [area]
    fleet.program.start()
    meet(fleet, first, epoch)
    with first.lock:
        # It only says so: otherwise where it stands would keep the others out.
        first.stands_in = []
        first.send()
    for robot in fleet.robots[1:]:
        robot.speaks = True
        fleet.expect(robot, STARTS_S, lambda heard: heard.message.mediator_epoch > epoch and heard.message.session != 0, "registration")
    fleet.robots[1].request(area)
    return area, first, fleet.robots[1], lied


@SUITE.check("believed-after-start", BELIEVED, needs=["--start", "2 robots"])
def believed_after_start(fleet: Fleet) -> None:
    """A grant with a fence that the journal does not know is believed in the first report after a start."""
    area, first, second, lied = claims_after_start(fleet, 1)
    fleet.refused(second, area, f"{first.robot_id} has it, with a fence larger than the journal's")
    heard = first.newest
    if heard is None or heard.access(area) != lied:
        raise Failed(f"{area} at {lied}", found(first))


@SUITE.check("known-fence-not-believed", BELIEVED, needs=["--start", "2 robots"])
def known_fence_not_believed(fleet: Fleet) -> None:
    """A grant with a fence that the journal knows of is not believed, not even in the first report after a start."""
    area, first, second, _ = claims_after_start(fleet, 0)
    fleet.expect(second, fleet.soon_s, holds(area), f"a grant of {area}, which {first.robot_id} only claims")


@SUITE.check("not-believed-not-acknowledged", "Until a robot is believed, `robot_sequence` does not acknowledge what it says", BODY,
             "What a robot says then is all that it has, and is taken over.", needs=["--start", "2 robots"])
def not_acknowledged(fleet: Fleet) -> None:
    """After a start with an empty journal reports are acknowledged once they are believed; then the robot still has its area."""
    first, second = fleet.robots[:2]
    area, = fleet.areas(1)
    claim = fleet.obtain(first, area)
    first.enter(area)
    fleet.expect(first, fleet.soon_s, at_progress(area, claim.run, 3), f"{area} entered")
    before = first.messages[-1].message
    fleet.restart(anew=True, go_on=True)
    assert fleet.program is not None

    def acknowledged(heard: Heard) -> bool:
        return heard.message.instance != before.instance and heard.message.robot_sequence > 0

    heard = fleet.expect(first, STARTS_S + page.SILENT_S + page.ENTERS_NO_MORE_S + fleet.soon_s, acknowledged, "reports that are acknowledged")
    if heard.at < fleet.program.started_at + page.ENTERS_NO_MORE_S:
        raise Failed(f"none within {page.ENTERS_NO_MORE_S:.0f} s of the start", f"one after {heard.at - fleet.program.started_at:.2f} s")
    second.request(area)
    fleet.refused(second, area, f"{first.robot_id} is in it")
    fleet.expect(first, fleet.soon_s, lambda heard: heard.access(area) == claim.then(3), f"level {claim.then(3)}")


@SUITE.check("session-of-no-epoch-before", "and is none that an earlier epoch may have given out", SESSIONS, needs=["--start"])
def session_of_no_epoch_before(fleet: Fleet) -> None:
    """After a start with an empty journal a robot's session is larger than that of the epoch which its reports tell of."""
    robot = fleet.robots[0]
    epoch, before = robot.mediator_epoch, robot.session
    fleet.restart(anew=True, go_on=True)
    heard = fleet.expect(robot, STARTS_S + page.SILENT_S + fleet.soon_s, lambda heard: heard.message.mediator_epoch > epoch
                         and heard.message.session != 0, f"a session under an epoch above {epoch}")
    if heard.message.session <= before:
        raise Failed(f"a session above {before}", str(heard.message.session))


@SUITE.check("session-grows", SESSIONS, needs=["--start"])
def session_grows(fleet: Fleet) -> None:
    """After a restart on the same journal the next process of a robot has a larger session than the one before."""
    before = fleet.robots[0].session
    robot = started(fleet, anew=False)[0]
    robot.speaks = True
    meet(fleet, robot)
    after = fleet.expect(robot, fleet.taken_in_s, lambda heard: heard.message.session != 0, "a session").message.session
    if after <= before:
        raise Failed(f"a session above {before}", str(after))


@SUITE.check("hears-before-it-speaks", "It sends nothing to a robot before it has heard it.", needs=["--start", "2 robots"], fresh=True)
def hears_before_it_speaks(fleet: Fleet) -> None:
    """After a start with an empty journal only the robot that reports gets messages."""
    robots = started(fleet, anew=True)
    fleet.heard_by_id.clear()
    robots[0].speaks = True
    meet(fleet, robots[0])
    time.sleep(fleet.watch_s)
    others = [robot.robot_id for robot in robots[1:] if fleet.heard_by_id.get(robot.robot_id)]
    if others:
        raise Failed("no message to a robot that has not spoken", f"messages to {', '.join(others)}")


@SUITE.check("first-numbers", "| `sequence` of a report, of a message to a robot | 1 | by one with each, in one epoch | 2^62 |",
             "| `mediator_epoch` | 1 | with every start of a mediator, and when it must be larger | 2^62 |", needs=["--start"], fresh=True)
def first_numbers(fleet: Fleet) -> None:
    """With an empty journal epoch and sequence begin with 1."""
    robot = started(fleet, anew=True)[0]
    robot.speaks = True
    message = meet(fleet, robot).message
    numbers = (message.mediator_epoch, robot.messages[0].message.sequence)
    if numbers != (1, 1):
        raise Failed("epoch 1, sequence 1", f"epoch {numbers[0]}, sequence {numbers[1]}")


def all_speak(fleet: Fleet) -> list[PlayedRobot]:
    """A mediator with an empty journal, and robots that are taken in."""
    robots = started(fleet, anew=True)
    for robot in robots:
        robot.speaks = True
    meet(fleet, robots[0])
    for robot in robots:
        fleet.register(robot)
    return robots


@SUITE.check("new-process-awaited", BODY, WAITS, needs=["--start", "2 robots"], fresh=True)
def new_process_awaited(fleet: Fleet) -> None:
    """After a start with an empty journal nothing is granted for 5 s, although all have said where they stand; then it is."""
    area, = fleet.areas(1)
    robot = all_speak(fleet)[0]
    robot.request(area)
    heard = fleet.expect(robot, page.ENTERS_NO_MORE_S + 3 * page.LEVEL_S + fleet.soon_s, holds(area), f"a grant of {area} to {robot.robot_id}")
    assert fleet.program is not None
    after = heard.at - fleet.program.started_at
    if after < page.ENTERS_NO_MORE_S:
        raise Failed(f"no grant within {page.ENTERS_NO_MORE_S:.0f} s of the start", f"one after {after:.2f} s")


@SUITE.check("late-report-not-believed", BODY, needs=["--start", "2 robots"], fresh=True)
def late_report(fleet: Fleet) -> None:
    """A report that was made within 5 s of the start does not say where the robot is, although it comes later."""
    area, = fleet.areas(1)
    robots = all_speak(fleet)
    first, last = robots[0], robots[-1]
    with last.lock:
        last.speaks, late = False, last.report().SerializeToString()
    first.request(area)
    fleet.believed()
    last.send(late)
    fleet.refused(first, area, f"all that {last.robot_id} has said was made within {page.ENTERS_NO_MORE_S:.0f} s of the start")
    last.speaks = True
    fleet.expect(first, fleet.soon_s + 3 * page.LEVEL_S, holds(area), f"a grant of {area} once {last.robot_id} speaks again")


@SUITE.check("waits-for-all", WAITS, needs=["--start", "2 robots"], fresh=True)
def waits_for_all(fleet: Fleet) -> None:
    """Nothing is granted while one robot of the site is not located; then it is."""
    area, = fleet.areas(1)
    robots = started(fleet, anew=True)
    last = robots[-1]
    last.located = False
    for robot in robots:
        robot.speaks = True
    meet(fleet, robots[0])
    for robot in robots:
        fleet.register(robot)
    fleet.believed()
    robots[0].request(area)
    fleet.refused(robots[0], area, f"{last.robot_id} has not said where it stands")
    with last.lock:
        last.located = True
        last.send()
    fleet.expect(robots[0], fleet.soon_s + 3 * page.LEVEL_S, holds(area), f"a grant of {area} once {last.robot_id} says where it stands")
