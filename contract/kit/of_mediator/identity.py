"""One process speaks for an identity."""

from __future__ import annotations

import time

from .. import page
from ..checks import Failed
from ..fleet import Fleet, holds
from ..played_robot import PlayedRobot
from . import SUITE

RESTART = ("After a quick restart that is over when the process before has been silent for 1 s, or for 5 s if it might still enter an "
           "area (see the lease below).")


def taken_in_after(fleet: Fleet, robot: PlayedRobot, since: float, least: float, most: float) -> None:
    """That a process is taken in no earlier and no later than so long after the other one spoke last."""
    heard = robot.wait(most + fleet.settings.margin_s, lambda heard: heard.message.session != 0)
    after = None if heard is None else heard.at - since
    if after is None or after < least:
        raise Failed(f"a session between {least:.1f} and {most + fleet.settings.margin_s:.1f} s after the last report of the one before",
                     "none" if after is None else f"one after {after:.2f} s")


@SUITE.check("identity-taken", "While it is heard, reports of any other boot are answered with a refusal, `identity_taken`")
def identity_taken(fleet: Fleet) -> None:
    """A second process is refused while the first is heard, and the first one loses nothing."""
    first = fleet.robots[0]
    area, = fleet.areas(1)
    fleet.obtain(first, area)
    second = fleet.process(first.robot_id)
    fleet.expect(second, fleet.soon_s, lambda heard: heard.message.identity_taken and heard.message.refusal != "",
                 "a refusal with identity_taken")
    fleet.never(second, fleet.watch_s, lambda heard: heard.message.session != 0 or len(heard.message.access) > 0, "no session, no levels")
    second.speaks = False
    fleet.never(first, fleet.watch_s, lambda heard: heard.message.identity_taken or not (heard.access(area) or None), "the first goes on")


@SUITE.check("identity-free-after-silence", RESTART)
def identity_free_after_silence(fleet: Fleet) -> None:
    """A new process is taken in after 1 s when the one before had nothing to enter; its session is larger."""
    first = fleet.robots[0]
    first.speaks = False
    sent = first.send()
    since = time.monotonic()
    fleet.expect(first, fleet.soon_s, lambda heard: heard.message.robot_sequence >= sent, f"robot_sequence {sent}")
    second = fleet.process(first.robot_id)
    taken_in_after(fleet, second, since, page.SILENT_S - 0.05, page.SILENT_S + page.LEVEL_S)
    if second.session <= first.session:
        raise Failed(f"a session above {first.session}", str(second.session))


@SUITE.check("identity-kept-by-lease", RESTART, "and a new process of the robot is not taken in.")
def identity_kept_by_lease(fleet: Fleet) -> None:
    """A new process is taken in only after 5 s when the one before had a grant that it had not entered."""
    first = fleet.robots[0]
    area, = fleet.areas(1)
    fleet.obtain(first, area)
    first.speaks = False
    first.send()
    since = time.monotonic()
    second = fleet.process(first.robot_id)
    taken_in_after(fleet, second, since, page.ENTERS_NO_MORE_S - 0.05, page.ENTERS_NO_MORE_S + page.LEVEL_S)
    fleet.robots[0] = second


@SUITE.check("identity-doubled", "the mediator tells people after 3 s, and the robot that goes on, with `identity_doubled`; the other one is "
             "not taken in by itself any more.")
def identity_doubled(fleet: Fleet) -> None:
    """Of two processes that both live on, one hears `identity_doubled` after 3 s; the other stays out though the first ends."""
    first, begin = fleet.robots[0], time.monotonic()
    second = fleet.process(first.robot_id)
    heard = fleet.expect(first, page.DOUBLED_S + 3 * page.LEVEL_S + fleet.settings.margin_s, lambda heard: heard.message.identity_doubled,
                         "identity_doubled to the one that goes on")
    if heard.at < begin + page.DOUBLED_S:
        raise Failed(f"identity_doubled only after {page.DOUBLED_S:.0f} s", f"it comes after {heard.at - begin:.2f} s")
    first.speaks = False
    fleet.never(second, page.ENTERS_NO_MORE_S + fleet.settings.margin_s, lambda heard: heard.message.session != 0,
                "no session for the second process")


@SUITE.check("offer-not-repeated", "| a process that was offered a session repeats it within | 5 s |")
def offer_not_repeated(fleet: Fleet) -> None:
    """A process that asks once, and never repeats the session that it is offered, keeps the next one out for 5 s at most."""
    first = fleet.robots[0]
    first.speaks = False
    time.sleep(page.SILENT_S + page.LEVEL_S)
    late = fleet.process(first.robot_id, speaks=False)
    late.send()
    fleet.expect(late, fleet.soon_s, lambda heard: heard.message.session != 0, "a session for a process that asks")
    fleet.robots[0] = fleet.process(first.robot_id)
    fleet.expect(fleet.robots[0], page.CANDIDATE_S + page.LEVEL_S + fleet.settings.margin_s, lambda heard: heard.message.robot_sequence > 0,
                 "a session for the next process, whose reports count")


@SUITE.check("session-kept", "Reports of an earlier session are ignored.")
def earlier_session(fleet: Fleet) -> None:
    """Requests in reports of the session before are not granted."""
    first = fleet.robots[0]
    first.speaks = False
    area, = fleet.areas(1)
    robot = fleet.process(first.robot_id)
    fleet.join(robot)
    fleet.robots[0] = robot
    robot.speaks, session = False, robot.session
    robot.session = first.session
    for _ in range(3):
        robot.request(area)
    fleet.refused(robot, area, "it was asked for in reports of an earlier session")
    robot.session, robot.claims, robot.speaks = session, {}, True


@SUITE.check("late-boot-ignored", "Reports of an earlier session are ignored.")
def late_boot(fleet: Fleet) -> None:
    """A late report of the process before, which had left the area, takes it from nobody."""
    area, = fleet.areas(1)
    first = fleet.robots[0]
    first.speaks = False
    second = fleet.process(first.robot_id)
    fleet.join(second)
    fleet.robots[0] = second
    claim = fleet.obtain(second, area)
    second.enter(area)
    with first.lock:
        first.claims[area] = claim.then(4)
        first.send()
    fleet.never(second, fleet.watch_s, lambda heard: not holds(area)(heard), f"{area} stays with the process that speaks")
