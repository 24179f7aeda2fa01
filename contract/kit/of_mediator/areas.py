"""Protocol 1 as it is meant: request, granted, entered, released, returned."""

from __future__ import annotations

from collections.abc import Callable

from ..checks import Failed
from ..fleet import Fleet, at_progress, found, holds
from ..played_robot import Claim, PlayedRobot
from . import SUITE

EMPTIED = "After the last flag of a run its reader empties the array: the next run begins with progress 0."
APART = "it grants an area to no more robots than its capacity, counting whoever stands in it."
FENCE = "The grant's `fence` grows with every grant of that area."


@SUITE.check("area-round", "| 0 | `request` (robot), `granted` (mediator), `entered` (robot), `released` (robot) |", EMPTIED,
             "Levels from `granted` on carry the fence of their grant")
def area_round(fleet: Fleet) -> None:
    """Request, granted, entered and released, with one fence; then the next run, empty."""
    robot, (area,) = fleet.robots[0], fleet.areas(1)
    claim = fleet.obtain(robot, area)
    if claim.fence < 1:
        raise Failed("a fence of at least 1 with the grant", f"{claim}")
    robot.enter(area)
    fleet.expect(robot, fleet.soon_s, lambda heard: heard.access(area) == claim.then(3), f"{claim.then(3)}")
    robot.leave(area)
    heard = fleet.expect(robot, fleet.soon_s, lambda heard: heard.access(area) is not None and heard.access(area).run > claim.run,
                         "the next run")
    if heard.access(area) != Claim(claim.run + 1, 0, 0, 0):
        raise Failed(f"{Claim(claim.run + 1)}", f"{heard.access(area)}")


@SUITE.check("returned", "| 1 | `request` (robot), `granted` (mediator), `returned` (robot) |", EMPTIED, needs=["2 robots"])
def returned(fleet: Fleet) -> None:
    """A grant that is given back is emptied, and goes to the next robot that asked."""
    first, second = fleet.robots[:2]
    area, = fleet.areas(1)
    claim = fleet.obtain(first, area)
    second.request(area)
    fleet.refused(second, area, f"{first.robot_id} has it")
    first.give_back(area)
    fleet.expect(first, fleet.soon_s, at_progress(area, claim.run + 1, 0), f"{area} emptied")
    fleet.granted(second, area)


@SUITE.check("released-goes-on", EMPTIED, APART, needs=["2 robots"])
def released_goes_on(fleet: Fleet) -> None:
    """An area goes to the next robot when the one before has left it, and not earlier."""
    first, second = fleet.robots[:2]
    area, = fleet.areas(1)
    fleet.obtain(first, area)
    first.enter(area)
    second.request(area)
    fleet.refused(second, area, f"{first.robot_id} is in it")
    first.leave(area)
    fleet.granted(second, area)


@SUITE.check("fence-grows", FENCE, needs=["2 robots"])
def fence_grows(fleet: Fleet) -> None:
    """Each of four grants of an area, to two robots in turn, has a larger fence than the one before."""
    area, = fleet.areas(1)
    fences = []
    for robot in (*fleet.robots[:2], *fleet.robots[:2]):
        claim = fleet.obtain(robot, area)
        fences.append(claim.fence)
        robot.give_back(area)
        fleet.expect(robot, fleet.soon_s, at_progress(area, claim.run + 1, 0), f"{area} emptied")
    if sorted(set(fences)) != fences:
        raise Failed("fences that grow", f"{fences}")


def ask_at_once(fleet: Fleet, area: str) -> Callable[[], int]:
    """Lets all robots ask for an area. Returns what counts the robots that have been told since that they have it, however soon they
    were told that they have it no longer: none gives it back."""
    asked = [(robot, len(robot.messages)) for robot in fleet.robots]
    for robot in fleet.robots:
        robot.request(area)
    return lambda: sum(any(map(holds(area), robot.messages[begin:])) for robot, begin in asked)


@SUITE.check("capacity-1", APART, needs=["2 robots"])
def capacity_one(fleet: Fleet) -> None:
    """Of robots that ask at once for an area for one, one gets it."""
    area, = fleet.areas(1)
    grants = ask_at_once(fleet, area)
    fleet.expect(fleet.robots[0], fleet.soon_s, lambda _: grants() >= 1, "a grant to one")
    fleet.never(fleet.robots[0], fleet.watch_s, lambda _: grants() > 1, f"one robot in {area}")


@SUITE.check("capacity-2", APART, needs=["3 robots"])
def capacity_two(fleet: Fleet) -> None:
    """Of three robots that ask at once for an area for two, two get it, and no third."""
    area, = fleet.areas(1, capacity=2)
    grants = ask_at_once(fleet, area)
    fleet.expect(fleet.robots[0], fleet.soon_s, lambda _: grants() >= 2, "grants to two")
    fleet.never(fleet.robots[0], fleet.watch_s, lambda _: grants() > 2, f"two robots in {area}")


@SUITE.check("waits-for", "`waits_for` says what it is, for people.", needs=["2 robots"])
def waits_for(fleet: Fleet) -> None:
    """Who waits is told why, and not any more once it is granted."""
    first, second = fleet.robots[:2]
    area, = fleet.areas(1)
    fleet.obtain(first, area)
    second.request(area)
    fleet.expect(second, fleet.soon_s, lambda heard: any(entry.area == area and entry.waits_for for entry in heard.message.access),
                 f"why {second.robot_id} waits for {area}")
    first.give_back(area)
    fleet.granted(second, area)
    if any(entry.area == area and entry.waits_for for entry in second.messages[-1].message.access):
        raise Failed("an empty waits_for once it is granted", found(second))


@SUITE.check("place", "`place` says how many come first: 1 is served next, as soon as the area has room and nobody holds it back.",
             needs=["3 robots"])
def place(fleet: Fleet) -> None:
    """Of two that wait for an area the first to ask has place 1, the other 2; once the first has it, its place is 0, the other's 1."""
    holder, first, second = fleet.robots[:3]
    area, = fleet.areas(1)
    fleet.obtain(holder, area)

    def comes(robot: PlayedRobot, number: int) -> None:
        fleet.expect(robot, fleet.soon_s, lambda heard: any(entry.area == area and entry.place == number for entry in heard.message.access),
                     f"place {number} of {robot.robot_id} for {area}")

    first.request(area)
    comes(first, 1)
    second.request(area)
    comes(second, 2)
    holder.give_back(area)
    fleet.granted(first, area)
    comes(first, 0)
    comes(second, 1)


@SUITE.check("asked-again", "Only then may the next first flag be set.")
def asked_again(fleet: Fleet) -> None:
    """The next run of an array is granted like the first."""
    robot, (area,) = fleet.robots[0], fleet.areas(1)
    for _ in range(3):
        claim = fleet.obtain(robot, area)
        robot.give_back(area)
        fleet.expect(robot, fleet.soon_s, at_progress(area, claim.run + 1, 0), f"{area} emptied")
    fleet.never(robot, fleet.watch_s, holds(area), f"no grant of {area} that was not asked for")


@SUITE.check("rests-until-acknowledged", "once the other side has heard how they rest: it has acknowledged (`robot_sequence`, `mediator_sequence`) a "
             "message with that level")
def rests_until_acknowledged(fleet: Fleet) -> None:
    """How an emptied array rests is in every message until the robot has acknowledged one that says so."""
    robot, (area,) = fleet.robots[0], fleet.areas(1)
    claim = fleet.obtain(robot, area)
    with robot.lock:
        # Its reports acknowledge no later message.
        robot.follows = False
        robot.give_back(area)
    rests = at_progress(area, claim.run + 1, 0)
    fleet.expect(robot, fleet.soon_s, rests, f"{area} emptied")
    fleet.never(robot, fleet.watch_s, lambda heard: not rests(heard),
                f"{area} at run {claim.run + 1}, progress 0 in every message, since reports acknowledge sequence {robot.echo} alone")
    robot.follows = True


@SUITE.check("run-said-again", "Whoever hears a `run` that is smaller than its own says its own again.")
def run_said_again(fleet: Fleet) -> None:
    """A robot that names an earlier run, of an array that rests, is told the present one."""
    robot, (area,) = fleet.robots[0], fleet.areas(1)
    claim = fleet.obtain(robot, area)
    robot.give_back(area)
    rests = at_progress(area, claim.run + 1, 0)
    fleet.expect(robot, fleet.soon_s, rests, f"{area} emptied")
    # By then it has been acknowledged, and may be left out.
    robot.wait(fleet.watch_s, lambda heard: heard.access(area) is None)
    with robot.lock:
        robot.messages.clear()
        robot.say(area, claim.then(3, path=1))
    fleet.expect(robot, fleet.soon_s, rests, f"{area} at run {claim.run + 1}, progress 0, since a report has named run {claim.run}")
