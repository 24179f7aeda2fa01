"""One mediator speaks for a site: what one does when robots follow another, or were lied to in its name."""

from __future__ import annotations

import time

from .. import page
from ..checks import Failed
from ..fleet import STARTS_S, Fleet, found, holds
from ..played_robot import Heard, PlayedRobot
from . import SUITE

GONE = ("Then it takes a larger `mediator_epoch`, larger than the robot's too if that has a registration or knows this `journal`, so that "
        "the robot follows it; waits for all robots again, also for those that were absent; and sends each no levels until it has reported "
        "under that epoch.")
LEASE = ("Nor does it acknowledge by `robot_sequence`, before that or while it stands by, any report of a robot that has an area in which it "
         "does not stand, so that it gets no lease (below)")
LIE = "A smaller lie in its name is believed, and its reports give it away: the mediator then takes a larger number."
STANDS_BY = ("while robots follow another one that it gives way to, it stands by (`stands_by`), grants and orders nothing, and registers "
             "nobody. The one with more robots goes on")
OTHER = "Reports with another instance than its own mean nothing to a mediator but this"


def follow_other(fleet: Fleet, robot: PlayedRobot, epoch: int) -> None:
    """The robot follows, and hears, a mediator with another journal and this epoch."""
    with robot.lock:
        robot.speaks = robot.follows = False
        robot.instance, robot.journal, robot.mediator_epoch, robot.echo = fleet.another_boot(), fleet.another_boot(), epoch, 1


def is_told_a_larger_epoch(fleet: Fleet) -> tuple[int, Heard]:
    """The first robot has followed another mediator, which is gone, and the last one is silent: that epoch, and what the first one is told."""
    first = fleet.robots[0]
    epoch = first.mediator_epoch + 50
    follow_other(fleet, first, epoch)
    fleet.robots[-1].speaks = False
    first.messages.clear()
    first.send()
    return epoch, fleet.expect(first, fleet.soon_s, lambda heard: heard.message.mediator_epoch > epoch, f"an epoch above {epoch}")


@SUITE.check("lied-epoch", LIE)
def lied_epoch(fleet: Fleet) -> None:
    """A robot that reports a larger epoch in this mediator's name is told a larger one still, and is taken in again."""
    fleet.believed()
    robot = fleet.robots[0]
    with robot.lock:
        robot.mediator_epoch += 1000
        lied = robot.mediator_epoch
        robot.send()
    fleet.expect(robot, fleet.soon_s, lambda heard: heard.message.mediator_epoch > lied, f"an epoch above {lied}")
    for other in fleet.robots:
        sent = other.sequence
        fleet.expect(other, fleet.soon_s, lambda heard, sent=sent: heard.message.robot_sequence > sent, "reports to count again")


@SUITE.check("other-mediator-gone", GONE, needs=["2 robots"])
def other_mediator_gone(fleet: Fleet) -> None:
    """A robot that has followed another mediator, which is gone, is told a larger epoch; nothing is granted until all are under it."""
    fleet.believed()
    first, last = fleet.robots[0], fleet.robots[-1]
    area, = fleet.areas(1)
    _, heard = is_told_a_larger_epoch(fleet)
    if len(heard.message.access) > 0:
        raise Failed("no levels before the robot has reported under the new epoch", found(first))
    first.speaks = first.follows = True
    first.request(area)
    fleet.refused(first, area, f"{last.robot_id} has not reported under the new epoch")
    last.speaks = True
    fleet.granted(first, area)


def enters_when_all_have_reported(fleet: Fleet, area: str, epoch: int) -> None:
    """Of another epoch the first robot has the area that it had, and no lease before the last one reports."""
    first, last = fleet.robots[0], fleet.robots[-1]
    fleet.expect(first, STARTS_S + fleet.taken_in_s, lambda heard: heard.message.mediator_epoch > epoch and holds(area)(heard),
                 f"the grant of {area}, which it has, under an epoch above {epoch}")
    fleet.never(first, fleet.watch_s, lambda heard: heard.message.mediator_epoch > epoch and heard.message.robot_sequence > 0,
                f"no lease before {last.robot_id} has reported")
    last.speaks = True
    sent = first.send()
    fleet.expect(first, fleet.taken_in_s, lambda heard: heard.message.robot_sequence >= sent, "its lease when all have")


@SUITE.check("no-lease-before-all", LEASE, needs=["2 robots"])
def no_lease_before_all(fleet: Fleet) -> None:
    """A grant that a robot has from another mediator is no lease here until all robots have reported."""
    fleet.believed()
    first = fleet.robots[0]
    area, = fleet.areas(1)
    fleet.obtain(first, area)
    epoch, _ = is_told_a_larger_epoch(fleet)
    first.speaks = first.follows = True
    enters_when_all_have_reported(fleet, area, epoch)


@SUITE.check("no-lease-after-start", LEASE, needs=["--start", "2 robots"])
def no_lease_after_start(fleet: Fleet) -> None:
    """A grant of before a restart is no lease until all robots have reported."""
    fleet.believed()
    first, last = fleet.robots[0], fleet.robots[-1]
    area, = fleet.areas(1)
    fleet.obtain(first, area)
    last.speaks = False
    epoch = first.mediator_epoch
    fleet.restart(go_on=True)
    enters_when_all_have_reported(fleet, area, epoch)


@SUITE.check("stands-by", STANDS_BY, OTHER, LEASE, needs=["3 robots"])
def stands_by(fleet: Fleet) -> None:
    """While two of three robots follow and hear another mediator this one grants nothing, gives no lease, and says so; then it goes on."""
    fleet.believed()
    loyal, *others = fleet.robots
    had, area = fleet.areas(2)
    fleet.obtain(loyal, had)
    instance, journal, epoch = fleet.another_boot(), fleet.another_boot(), loyal.mediator_epoch + 10
    for robot in others:
        follow_other(fleet, robot, epoch)
        robot.instance, robot.journal = instance, journal
    end = time.monotonic() + page.SILENT_S + fleet.watch_s
    asked = said = False
    while time.monotonic() < end:
        for robot in others:
            report = robot.report()
            report.mediator_heard = True
            robot.send(report.SerializeToString())
        if not asked and (said := loyal.newest is not None and loyal.newest.message.stands_by):
            loyal.request(area)
            asked = True
        time.sleep(page.LEVEL_S / 2)
    if not said:
        raise Failed("stands_by to the robot that follows this mediator", found(loyal))
    if loyal.claims[area].held:
        raise Failed("no grant while it stands by", found(loyal))
    if loyal.newest is not None and loyal.newest.message.stands_by and loyal.newest.message.robot_sequence > 0:
        raise Failed("no lease while it stands by", found(loyal))
    for robot in others:
        robot.speaks = robot.follows = True
        robot.messages.clear()
    for robot in fleet.robots:
        fleet.expect(robot, page.SILENT_S + fleet.soon_s, lambda heard: heard.message.mediator_epoch > epoch and not heard.message.stands_by,
                     f"an epoch above {epoch}, standing by no more")
    fleet.granted(loyal, area)


@SUITE.check("other-instance-counts-not", OTHER)
def other_instance(fleet: Fleet) -> None:
    """Levels in reports that name another instance do not count."""
    robot, (area,) = fleet.robots[0], fleet.areas(1)
    with robot.lock:
        robot.speaks, right, last = False, robot.instance, robot.sequence
        robot.instance = fleet.another_boot()
        for _ in range(3):
            report = robot.report()
            report.mediator_heard = True
            report.access.add(area=area).level.progress = 1
            report.access[0].level.run = robot.claims[area].run if area in robot.claims else 0
            robot.send(report.SerializeToString())
    fleet.never(robot, page.LEVEL_S * 4, lambda heard: heard.message.robot_sequence > last or heard.access(area) is not None
                and heard.access(area).held, "neither a grant nor a lease for reports with another instance")
    robot.instance, robot.speaks = right, True
    sent = robot.send()
    fleet.expect(robot, fleet.taken_in_s, lambda heard: heard.message.robot_sequence >= sent, "reports that count again")
