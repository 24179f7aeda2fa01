"""The lease: a grant that the robot does not stand in may be used only while the mediator is known to hear it."""

from __future__ import annotations

import time

from .. import page
from ..hall import Hall
from . import SUITE
from .mediators import other_mediator

LEASE = "It may go on to reach into a granted area in which it does not stand only while that is less than **1 s** ago."
SENT = "The robot remembers when it sent that report, by its own clock."
OVER = "When the time is over it no longer may: if it can still stop before the border it does, else it may roll in."
SILENT = ("A robot that has heard nothing from the mediator for 1 s keeps what it has, and stops before the border of any area in which it does "
          "not stand, granted or not.")
OTHERS = ("A robot that hears another mediator than the one it follows has no lease for 1 s from then on, unless that one stands by or has ended "
          "(the `journal` that the robot knows, and a smaller `mediator_epoch`)")
WITHIN = "| from the last moment to reach in until it has or stands | 3.9 s |"


def stays_out(hall: Hall, area: str, seconds: float, why: str) -> None:
    """That the robot does not reach into an area that it was granted."""
    hall.never(seconds, lambda said: area in said.report.stands_in, f"{area} not entered: {why}")


def enters(hall: Hall, area: str, why: str) -> None:
    """That it does."""
    hall.expect(hall.patience_s, lambda said: area in said.report.stands_in, f"{area} entered: {why}")


@SUITE.check("lease-kept", LEASE, OVER)
def lease_kept(hall: Hall) -> None:
    """A grant that comes after `robot_sequence` has stood still for over 1 s is not used, until that goes on."""
    area = hall.ahead()
    hall.echoes = False
    time.sleep(page.LEASE_S + 2 * page.LEVEL_S)
    hall.let_into(area)
    stays_out(hall, area, page.ENTERS_WITHIN_S + page.LEASE_S, "the lease is over")
    hall.echoes = True
    enters(hall, area, "it is granted, with a lease")


@SUITE.check("lease-from-sending", SENT, LEASE)
def lease_from_sending(hall: Hall) -> None:
    """While `robot_sequence` goes on, but always names a report that was sent 1.5 s ago, no grant is used."""
    area = hall.ahead()
    hall.echo_behind_s = 1.5 * page.LEASE_S
    time.sleep(2 * page.LEASE_S)
    hall.let_into(area)
    stays_out(hall, area, page.ENTERS_WITHIN_S + page.LEASE_S, "the report that the mediator names was sent over a second ago")
    hall.echo_behind_s = 0.0
    enters(hall, area, "it is granted, with a lease")


@SUITE.check("lease-of-unknown-number", LEASE)
def lease_of_unknown(hall: Hall) -> None:
    """A `robot_sequence` that the robot has not sent yet gives no lease."""
    area = hall.ahead()
    hall.echoes = False
    hall.robot_sequence = hall.said[-1].report.sequence + 10**6
    time.sleep(page.LEASE_S + 2 * page.LEVEL_S)
    hall.let_into(area)
    stays_out(hall, area, page.ENTERS_WITHIN_S + page.LEASE_S, "the mediator names a report that there is not")
    hall.robot_sequence, hall.echoes = 0, True
    enters(hall, area, "it is granted, with a lease")


@SUITE.check("lease-of-one-mediator", OTHERS)
def lease_of_one_mediator(hall: Hall) -> None:
    """While another mediator speaks to it, which may let somebody into the same area, no grant is used."""
    area = hall.ahead()
    other = other_mediator(hall, hall.epoch + 10)
    hall.put(other)
    hall.let_into(area)
    begin = time.monotonic()
    while time.monotonic() < begin + page.ENTERS_WITHIN_S + page.LEASE_S:
        other.sequence += 1
        hall.put(other)
        stays_out(hall, area, page.SILENT_S / 2, "another mediator may grant the same")
    enters(hall, area, "the other one is silent")


@SUITE.check("silence-keeps-and-stops", SILENT, WITHIN)
def silence(hall: Hall) -> None:
    """While the mediator is silent the robot keeps what it stands in, reports on, and newly enters nothing after 4.9 s."""
    area = hall.ahead()
    hall.let_into(area)
    hall.speaks = False
    time.sleep(page.LEASE_S + page.ENTERS_WITHIN_S)
    before = hall.stands_in()
    hall.never(3.0, lambda said: not set(said.report.stands_in) <= before
               or any(not (said.access(name) and said.access(name).held) for name in said.report.stands_in),
               f"no area but {sorted(before)}, and those kept")
    hall.speaks = True
    enters(hall, area, "the mediator is back")


@SUITE.check("grant-in-last-words", LEASE, SILENT)
def last_words(hall: Hall) -> None:
    """A grant in a message with an old `robot_sequence`, the last before a silence, is not used."""
    area = hall.ahead()
    hall.speaks = False
    time.sleep(page.SILENT_S + 2 * page.LEVEL_S)
    hall.let_into(area)
    stays_out(hall, area, page.ENTERS_WITHIN_S + page.LEASE_S, "all that the mediator has heard is over a second old")
    hall.speaks = True
    enters(hall, area, "it is granted, with a lease")
