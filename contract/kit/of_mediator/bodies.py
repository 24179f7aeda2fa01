"""Bodies of processes that do not speak for their robot: what they say of where they stand counts, whoever else is heard."""

from __future__ import annotations

import time

from .. import page
from ..fleet import STARTS_S, Fleet, at_progress, holds
from ..floor import floor_hash
from ..played_robot import PlayedRobot
from . import SUITE

ANOTHER = ("It is another body all the same: where it says that it stands nobody is let in, whoever else is heard, until it says that it stands "
           "elsewhere, or an operator that it was taken away.")
SILENT = "That holds when it is silent, too, and when the mediator starts again with its journal"
LOST = "One that does not know where it is keeps nobody out"
REFUSED = ("A process that is refused for its floor or its version counts with where it says that it stands, as any other: beside one that "
           "is heard as a second one, from its first report on, and alone as the robot's own body.")
ELSEWHERE = ("So the process before is taken for a second one that was found, in every area in which it stood or which it had. These stay "
             "blocked, whatever the new process gives back, also while the one before is silent, and when the mediator starts again with its "
             "journal, until that one says that it stands elsewhere")
STAYS = "Where it was last it is, also when it is silent and after the mediator has started again, until it says that it stands elsewhere"


class Body:
    """A process in an area that does not speak for its robot, and somebody who wants that area."""

    def __init__(self, fleet: Fleet, of: PlayedRobot, has_floor: bool = True) -> None:
        self.fleet, self.robot = fleet, fleet.robots[1]
        self.area, = fleet.areas(1)
        self.process = fleet.process(of.robot_id, speaks=False)
        if not has_floor:
            self.process.areas = fleet.changed_floor(0)
            self.process.hash = floor_hash(self.process.areas)
        self.stands(self.area)
        # Links are not in step: a request on another one may overtake this report.
        fleet.expect(self.process, fleet.soon_s, lambda heard: True, "an answer to where it stands")
        self.process.speaks = True

    def stands(self, *areas: str) -> None:
        """It says that it stands there."""
        with self.process.lock:
            self.process.stands_in = list(areas)
            self.process.send()

    def keeps_out(self, why: str) -> None:
        """Nobody is let in."""
        self.robot.request(self.area)
        self.fleet.refused(self.robot, self.area, why)

    def leaves(self) -> None:
        """It goes away, and somebody is let in, so that the next check finds the area free."""
        self.stands()
        self.process.speaks = True
        self.fleet.granted(self.robot, self.area)
        self.process.speaks = False


def beside(fleet: Fleet, body: Body) -> None:
    """Waits until the process was found beside the one that speaks for the robot."""
    fleet.expect(fleet.robots[0], page.DOUBLED_S + 3 * page.LEVEL_S + fleet.settings.margin_s, lambda heard: heard.message.identity_doubled,
                 f"identity_doubled to {fleet.robots[0].robot_id}, of which two processes report")
    body.keeps_out(f"a second process of {fleet.robots[0].robot_id} stands in it")


def over_a_start(fleet: Fleet) -> None:
    """Kills the mediator and starts it again with its journal, and waits until it has heard all robots."""
    epoch = max(robot.mediator_epoch for robot in fleet.robots)
    fleet.restart(go_on=True)
    for robot in fleet.robots:
        fleet.expect(robot, STARTS_S + fleet.taken_in_s, lambda heard: heard.message.mediator_epoch > epoch and heard.message.session != 0,
                     "registration")


@SUITE.check("second-body", ANOTHER, SILENT, needs=["2 robots"])
def second_body(fleet: Fleet) -> None:
    """Where a second process of a robot stands nobody is let in, also when it is silent; when it says that it is elsewhere, somebody is."""
    body = Body(fleet, fleet.robots[0])
    body.keeps_out(f"a process of {fleet.robots[0].robot_id} stands in it")
    beside(fleet, body)
    body.process.speaks = False
    time.sleep(2 * page.SILENT_S)
    body.keeps_out(f"a second process of {fleet.robots[0].robot_id} stood there when it was heard last")
    body.leaves()


@SUITE.check("second-body-over-start", SILENT, needs=["--start", "2 robots"])
def second_body_over_start(fleet: Fleet) -> None:
    """A mediator that starts again with its journal knows where a second process stood that is silent."""
    body = Body(fleet, fleet.robots[0])
    beside(fleet, body)
    body.process.speaks = False
    over_a_start(fleet)
    body.keeps_out(f"a second process of {fleet.robots[0].robot_id} stood there when the mediator before heard it last")
    body.leaves()


@SUITE.check("second-body-lost", LOST, needs=["2 robots"])
def second_body_lost(fleet: Fleet) -> None:
    """A second process that does not know where it is keeps nobody out, whatever it says."""
    area, = fleet.areas(1)
    process = fleet.process(fleet.robots[0].robot_id, speaks=False)
    process.located, process.stands_in, process.speaks = False, [area], True
    fleet.expect(process, fleet.soon_s, lambda heard: heard.message.identity_taken, "a refusal with identity_taken")
    fleet.obtain(fleet.robots[1], area)


@SUITE.check("refused-body", REFUSED, ANOTHER, needs=["2 robots"])
def refused_body(fleet: Fleet) -> None:
    """Where a process stands that is refused for its floor, beside one that is heard, nobody is let in, from its first report on."""
    body = Body(fleet, fleet.robots[0], has_floor=False)
    body.keeps_out(f"a process of {fleet.robots[0].robot_id} with another floor stands in it")
    beside(fleet, body)
    body.leaves()


def refused_alone(fleet: Fleet) -> Body:
    """The first robot is heard no more, and a process of it that is refused says that it stands in the area."""
    first = fleet.robots[0]
    first.speaks = False
    time.sleep(page.SILENT_S + page.LEVEL_S)
    body = Body(fleet, first, has_floor=False)
    body.keeps_out(f"a process of {first.robot_id} with another floor stands in it")
    body.process.speaks = False
    return body


@SUITE.check("refused-body-alone", REFUSED, STAYS, needs=["2 robots"])
def refused_body_alone(fleet: Fleet) -> None:
    """Where a process stands that is refused, and nobody else is heard as that robot, nobody is let in, also when it is silent."""
    body = refused_alone(fleet)
    time.sleep(2 * page.SILENT_S)
    body.keeps_out(f"a process of {fleet.robots[0].robot_id} with another floor stood there when it was heard last")
    body.leaves()
    time.sleep(page.SILENT_S + page.LEVEL_S)
    fleet.robots[0].speaks = True


@SUITE.check("refused-body-over-start", STAYS, needs=["--start", "2 robots"])
def refused_body_over_start(fleet: Fleet) -> None:
    """A mediator that starts again with its journal knows where one stood that was refused, and is silent."""
    body = refused_alone(fleet)
    fleet.robots[0].speaks = True
    over_a_start(fleet)
    body.keeps_out(f"a process of {fleet.robots[0].robot_id} with another floor stood there when the mediator before heard it last")
    body.leaves()


@SUITE.check("starts-elsewhere", ELSEWHERE, needs=["2 robots"])
def starts_elsewhere(fleet: Fleet) -> None:
    """Where a robot stood that starts anew in no area nobody is let in, until the process before says that it has left."""
    first, second = fleet.robots[:2]
    area, = fleet.areas(1)
    claim = fleet.obtain(first, area)
    first.enter(area)
    fleet.expect(first, fleet.soon_s, at_progress(area, claim.run, 3), f"{area} entered")
    first.speaks = False
    fleet.robots[0] = fleet.process(first.robot_id)
    fleet.join(fleet.robots[0])
    second.request(area)
    fleet.refused(second, area, f"{first.robot_id} stood in it when it was heard last, and its next process is in no area")
    with first.lock:
        # It wakes up, is told that another process speaks for the robot, and reports on.
        first.stands_in, first.claims, first.speaks = [], {}, True
    fleet.expect(second, 2 * fleet.soon_s, holds(area), f"a grant of {area}, where the process before of {first.robot_id} is no more")
    first.speaks = False
