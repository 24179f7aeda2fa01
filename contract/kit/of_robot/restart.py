"""What a robot says that has just started. These checks start and kill it."""

from __future__ import annotations

import time
from typing import Any

from .. import page, wire
from ..checks import Failed, Skipped
from ..floor import HASH_OF_NOTHING, floor_hash
from ..hall import Hall
from ..played_robot import Claim
from . import SUITE
from .mediators import other_mediator

DRAWS = "A robot draws a random `boot_epoch` when it starts, and sends reports with `mediator_epoch` 0 and `session` 0."
HEARD = "That is where the robot was heard last, not where it is: it may have driven on unheard, or been pushed."
BEFORE = ("Of areas that it had before it restarted, those it is surely not in are released or returned at once, and not entered before they are "
          "granted anew.")
PLACES_M = 1.0


def started(hall: Hall) -> int:
    """The robot started again, and no mediator that speaks. Returns the boot before."""
    before = hall.said[-1].report.boot_epoch
    hall.start_robot()
    hall.expect(hall.patience_s, lambda said: said.report.boot_epoch != before, "reports with another boot_epoch after a restart")
    time.sleep(2 * page.LEVEL_S)
    return int(before)


def speak(hall: Hall) -> None:
    """The mediator speaks, with the robot's boot and floor."""
    with hall.lock:
        hall.start_mediator()
        hall.react(hall.said[-1])
        hall.send()


@SUITE.check("first-reports", DRAWS, "While a robot has no registration its reports list the areas too, in `floor`", needs=["--start"])
def first_reports(hall: Hall) -> None:
    """It starts with another boot epoch, epoch 0 and session 0, and lists its areas, or none with the hash of none."""
    started(hall)
    report = hall.said[-1].report
    if (report.mediator_epoch, report.session, report.boot_epoch == 0) != (0, 0, False):
        raise Failed("mediator_epoch 0, session 0, boot_epoch not 0", hall.found())
    if floor_hash(report.floor) != report.floor_hash:
        raise Failed("floor_hash of the areas that it lists", f"{report.floor_hash:016x}, and {len(report.floor)} areas")


@SUITE.check("floor-taken", "it takes the list from the refusal, and repeats that hash from then on.", needs=["--start"])
def floor_taken(hall: Hall) -> None:
    """A robot that lists no area takes the mediator's, and repeats their hash."""
    started(hall)
    if hall.said[-1].report.floor_hash != HASH_OF_NOTHING:
        raise Skipped("the robot brings a floor of its own")
    speak(hall)
    expected = floor_hash(hall.floor)
    hall.expect(hall.soon_s, lambda said: said.report.floor_hash == expected, f"floor_hash {expected:016x}")
    hall.expect(hall.soon_s, hall.counts, "registration")


@SUITE.check("first-mediator-taken", "A robot without a registration takes the first mediator that offers one",
             "A refusal with `stands_by` says nothing else: its epoch does not count.", needs=["--start"])
def first_mediator(hall: Hall) -> None:
    """After the refusal of one that stands by, with a huge epoch, the mediator that offers a session is taken."""
    started(hall)
    with hall.lock:
        hall.boot_epoch = hall.said[-1].report.boot_epoch
        message = other_mediator(hall, 2**60, stands_by=True, refusal="it stands by")
        message.session = 0
        hall.put(message)
    time.sleep(page.LEVEL_S)
    speak(hall)
    hall.expect(hall.soon_s, hall.counts, f"registration with the mediator of epoch {hall.epoch}")


@SUITE.check("inherited-given-back", BEFORE, "The robot takes over the levels in that answer as its own", needs=["--start"])
def inherited(hall: Hall) -> None:
    """Grants of the process before, of areas that the new one is surely not in, are returned and released with their fence."""
    started(hall)
    with hall.lock:
        report = hall.said[-1].report
        hall.learn_floor(report)
        free = [area.id for area in hall.floor if area.id not in report.stands_in and not near(area, report)]
        if len(free) < 2:
            raise Skipped("the floor needs two areas away from the robot")
        hall.levels = {free[0]: Claim(7, 0, 2, 30), free[1]: Claim(8, 0, 3, 40)}
        hall.fences, hall.full, hall.grants = {free[0]: 30, free[1]: 40}, set(free[:2]), lambda name: name in hall.stands_in()
    speak(hall)
    hall.expect(hall.patience_s, lambda said: said.access(free[0]) == Claim(7, 1, 3, 30), f"{free[0]} returned: 7/1/3, fence 30")
    hall.expect(hall.patience_s, lambda said: said.access(free[1]) == Claim(8, 0, 4, 40), f"{free[1]} released: 8/0/4, fence 40")


def near(area: Any, report: Any) -> bool:
    """Whether the robot may stand in the area by its pose, before it has named any."""
    x, y = report.pose.x_m, report.pose.y_m
    return (area.min_x_m - PLACES_M < x < area.max_x_m + PLACES_M
            and area.min_y_m - PLACES_M < y < area.max_y_m + PLACES_M)


@SUITE.check("take-up-not-believed", HEARD, needs=["--start"])
def take_up(hall: Hall) -> None:
    """A robot is not located where `take_up` says that it was heard last, unless it was before it heard that."""
    started(hall)
    before = hall.said[-1].report
    with hall.lock:
        hall.learn_floor(before)
        far = [area for area in hall.floor if not near(area, before)]
        if not far:
            raise Skipped("the floor needs an area away from the robot")
        x, y = (far[-1].min_x_m + far[-1].max_x_m) / 2, (far[-1].min_y_m + far[-1].max_y_m) / 2
        hall.take_up = wire.TakeUp(pose=wire.Pose(x_m=x, y_m=y), fsm_state=before.fsm_state)
        hall.grants = lambda name: False
    # In the answer to the first report already, whatever that said.
    with hall.lock:
        hall.start_mediator()
        hall.react(hall.said[-1])
        for _ in range(5):
            hall.put(hall.message(take_up=hall.take_up))
            hall.sequence += 1
    hall.expect(hall.soon_s, hall.counts, "registration")
    hall.never(2.0, lambda said: said.report.located and abs(said.report.pose.x_m - x) + abs(said.report.pose.y_m - y) < PLACES_M,
               f"not located at ({x:.2f}, {y:.2f}), where it was heard last")
