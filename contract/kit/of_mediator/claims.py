"""What robots say that cannot be: it must change nothing."""

from __future__ import annotations

import time

from .. import page
from ..checks import Failed
from ..fleet import Fleet, found, holds
from ..played_robot import Claim
from . import SUITE

NEW = "A level with a smaller run, or the same run and less progress on the same path, says nothing new."
YOURS = "A level may add only flags of its sender. One that claims yours is wrong: ignore it, and count it."
FENCE = "One with another fence, or with none, is refused, and people are told."
BELIEVED = "A robot is believed to have a grant that the mediator does not know of only in its first report after a start of the mediator"
NEWEST = "Within one epoch of the sender, the message with the largest `sequence` is the newest; ignore older ones."


def keeps(fleet: Fleet, area: str, why: str) -> None:
    """That the first robot keeps an area, and the second one does not get it."""
    first, second = fleet.robots[:2]
    second.request(area)
    fleet.refused(second, area, why)
    newest = first.newest
    if newest is None or not holds(area)(newest):
        raise Failed(f"{area} stays with {first.robot_id}: {why}", found(first))


@SUITE.check("wrong-fence", FENCE, needs=["2 robots"])
def wrong_fence(fleet: Fleet) -> None:
    """`released` with a larger, a smaller and no fence does not free the area; with the right one it does."""
    first, second = fleet.robots[:2]
    area, = fleet.areas(1)
    claim = fleet.obtain(first, area)
    first.enter(area)
    first.stands_in = []
    for fence in (claim.fence + 1, claim.fence - 1, 0):
        first.say(area, Claim(claim.run, 0, 4, fence))
        keeps(fleet, area, f"it was released with fence {fence}, not {claim.fence}")
    first.say(area, claim.then(4))
    fleet.granted(second, area)


@SUITE.check("wrong-fence-returned", FENCE, needs=["2 robots"])
def wrong_fence_returned(fleet: Fleet) -> None:
    """`returned` with another fence does not free the area."""
    area, = fleet.areas(1)
    claim = fleet.obtain(fleet.robots[0], area)
    fleet.robots[0].say(area, Claim(claim.run, 1, 3, claim.fence + 1))
    keeps(fleet, area, "it was returned with another fence")
    fleet.robots[0].claims[area] = claim


@SUITE.check("entered-not-believed", BELIEVED, needs=["2 robots"])
def entered_not_believed(fleet: Fleet) -> None:
    """A robot that claims to have entered by a grant that never was gets nothing by it."""
    first, second = fleet.robots[:2]
    area, = fleet.areas(1)
    first.say(area, Claim(first.claims.get(area, Claim()).run, 0, 3, 10**6))
    fleet.refused(first, area, "it was never granted")
    second.request(area)
    fleet.granted(second, area)
    first.claims.pop(area)


@SUITE.check("granted-not-claimed", YOURS, needs=["2 robots"])
def granted_not_claimed(fleet: Fleet) -> None:
    """A robot that sets the mediator's `granted` itself gets nothing by it."""
    first, second = fleet.robots[:2]
    area, = fleet.areas(1)
    fleet.obtain(second, area)
    for fence in (0, second.claims[area].fence, second.claims[area].fence + 1):
        first.say(area, Claim(first.claims.get(area, Claim()).run, 0, 2, fence))
        fleet.refused(first, area, f"{second.robot_id} has it, and only the mediator grants")
    first.claims.pop(area)


@SUITE.check("old-sequence", NEWEST)
def old_sequence(fleet: Fleet) -> None:
    """A request in a report with an older sequence is ignored, as one that came late."""
    robot, (area,) = fleet.robots[0], fleet.areas(1)
    with robot.lock:
        run = robot.claims.get(area, Claim()).run
        late = robot.report()
        late.access.add(area=area).level.run = run
        late.access[-1].level.progress = 1
        sent = robot.send()
    fleet.expect(robot, fleet.soon_s, lambda heard: heard.message.robot_sequence >= sent, f"robot_sequence {sent}")
    robot.speaks = False
    for _ in range(3):
        robot.send(late.SerializeToString())
    fleet.refused(robot, area, "it was asked for in a late report alone", page.SILENT_S * 0.8)
    newest = robot.newest
    if newest is None or newest.message.robot_sequence < sent:
        raise Failed(f"robot_sequence {sent}", found(robot))
    robot.speaks = True


@SUITE.check("sequence-bounded", "A report whose `sequence` is above 2^61, and more than 2^20 above the last one that counted, is dropped")
def sequence_bounded(fleet: Fleet) -> None:
    """One report in a robot's name with a number far ahead does not make its own ones old."""
    robot = fleet.robots[0]
    with robot.lock:
        lie = robot.report()
        lie.sequence = 2**61 + 2**20
    for _ in range(3):
        robot.send(lie.SerializeToString())
    sent = robot.send()
    fleet.expect(robot, fleet.soon_s, lambda heard: sent <= heard.message.robot_sequence < lie.sequence, f"robot_sequence {sent}")


@SUITE.check("repeated-report", "so a lost, repeated or late one does no harm.")
def repeated_report(fleet: Fleet) -> None:
    """A report of a request that comes again after the area was returned asks for nothing."""
    robot, (area,) = fleet.robots[0], fleet.areas(1)
    with robot.lock:
        run = robot.claims.get(area, Claim()).run
        robot.claims[area] = Claim(run, 0, 1)
        again = robot.report().SerializeToString()
    robot.send(again)
    fleet.granted(robot, area)
    robot.give_back(area)
    fleet.expect(robot, fleet.soon_s, lambda heard: heard.access(area) == Claim(run + 1), f"{area} emptied")
    for _ in range(5):
        robot.send(again)
    fleet.refused(robot, area, "the report that asked for it is old")


@SUITE.check("smaller-run", NEW, needs=["2 robots"])
def smaller_run(fleet: Fleet) -> None:
    """The end of an earlier run does not end the present one, nor does less progress."""
    robot, (area,) = fleet.robots[0], fleet.areas(1)
    before = fleet.obtain(robot, area)
    robot.give_back(area)
    fleet.expect(robot, fleet.soon_s, lambda heard: heard.access(area) == Claim(before.run + 1), f"{area} emptied")
    claim = fleet.obtain(robot, area)
    robot.enter(area)
    for old in (before.then(4), before.then(3, path=1), Claim(claim.run, 0, 1, 0)):
        robot.say(area, old)
        keeps(fleet, area, f"a level {old} is an old one")
    robot.claims[area] = claim.then(3)


@SUITE.check("left-out", "Leaving something out says nothing.", needs=["2 robots"])
def left_out(fleet: Fleet) -> None:
    """An area that reports do not mention any more stays with the robot."""
    robot, (area,) = fleet.robots[0], fleet.areas(1)
    robot.follows = True
    claim = fleet.obtain(robot, area)
    robot.follows = False
    time.sleep(0.05)
    with robot.lock:
        robot.claims.pop(area)
        robot.send()
    keeps(fleet, area, "it was only left out")
    robot.claims[area], robot.follows = claim, True


@SUITE.check("unknown-area", "Robots and mediator must know the same areas.")
def unknown_area(fleet: Fleet) -> None:
    """A request for an area that the floor does not have is not granted, and spoils nothing."""
    robot, (area,) = fleet.robots[0], fleet.areas(1)
    robot.request("no-such-area")
    fleet.obtain(robot, area)
    fleet.refused(robot, "no-such-area", "the floor does not have it")
    robot.claims.pop("no-such-area")
