"""Bytes and numbers that no robot means: an honest one must not feel them."""

from __future__ import annotations

import random
import time

from .. import page, wire
from ..checks import Failed
from ..fleet import Fleet, found
from ..played_robot import Claim, PlayedRobot
from . import SUITE

LEVELS = ("Messages are *levels, not edges*: each carries all there is to know, so a lost, repeated or late one does no harm.")
SIZE = "Messages above 1 MiB are dropped on both sides."


def round_trip(fleet: Fleet, robot: PlayedRobot) -> None:
    """That a robot is served as ever: a request is granted, and what is returned is emptied."""
    area, = fleet.areas(1)
    claim = fleet.obtain(robot, area)
    robot.give_back(area)
    fleet.expect(robot, fleet.soon_s, lambda heard: heard.access(area) == Claim(claim.run + 1), f"{area} emptied")


@SUITE.check("malformed-bytes", LEVELS)
def malformed_bytes(fleet: Fleet) -> None:
    """Bytes that are no message, on the robot's own key, change nothing for it."""
    robot, draw = fleet.robots[0], random.Random(1)
    whole = robot.report().SerializeToString()
    for _ in range(100):
        robot.send(bytes(draw.getrandbits(8) for _ in range(draw.randrange(80))))
        robot.send(whole[:draw.randrange(len(whole))])
    robot.send(b"")
    round_trip(fleet, robot)


@SUITE.check("oversized-dropped", SIZE)
def oversized_dropped(fleet: Fleet) -> None:
    """A report above 1 MiB, right but for its length, does not count; one below does."""
    robot, (area,) = fleet.robots[0], fleet.areas(1)
    with robot.lock:
        robot.speaks = False
        before = robot.claims.get(area, Claim())
        robot.claims[area] = before.then(1)
        report = robot.report().SerializeToString()
        # Kept, since the mediator need not say the run again that it has said.
        robot.claims[area] = before
        robot.send(report + wire.unknown_field(999, wire.LONGEST_MESSAGE))
    fleet.refused(robot, area, "the report that asks for it is too long", page.SILENT_S * 0.8)
    robot.speaks = True
    with robot.lock:
        sequence = robot.sequence + 1
        robot.send(robot.report().SerializeToString() + wire.unknown_field(999, wire.LONGEST_MESSAGE // 2))
    fleet.expect(robot, fleet.soon_s, lambda heard: heard.message.robot_sequence >= sequence, f"robot_sequence {sequence}")
    round_trip(fleet, robot)


@SUITE.check("flood", LEVELS, "| whoever was not heard for longer is silent | 1 s |")
def flood(fleet: Fleet) -> None:
    """For 3 s a thousand reports a second of strangers, liars and noise: the honest robot never finds the mediator silent."""
    robot, draw = fleet.robots[-1], random.Random(2)
    strangers = [fleet.process(f"stranger-{at}", speaks=False) for at in range(20)]
    rival = fleet.process(robot.robot_id, speaks=False)
    begin = time.monotonic()
    sent = 0
    while (now := time.monotonic()) < begin + 3.0:
        if sent > (now - begin) * 1000:
            time.sleep(0.002)
            continue
        sent += 1
        kind = draw.randrange(3)
        if kind == 0:
            draw.choice(strangers).send()
        elif kind == 1:
            rival.send(bytes(draw.getrandbits(8) for _ in range(50)))
        else:
            liar = rival.report()
            liar.session, liar.mediator_epoch = draw.getrandbits(63), robot.mediator_epoch
            liar.stands_in.append("x" * draw.randrange(200))
            rival.send(liar.SerializeToString())
    end = time.monotonic()
    times = [begin, *(heard.at for heard in robot.messages if begin < heard.at < end), end]
    gap = max(later - earlier for earlier, later in zip(times, times[1:]))
    if gap > page.SILENT_S:
        raise Failed(f"the honest robot hears the mediator within {page.SILENT_S:.0f} s all the while", f"a gap of {gap:.2f} s")
    time.sleep(page.LEVEL_S)
    round_trip(fleet, robot)


@SUITE.check("numbers-at-the-end", "| `run` of an area | 0; after a registration as the mediator says | when an array is emptied or given up | "
             "2^31 - 1 |", LEVELS)
def numbers_at_the_end(fleet: Fleet) -> None:
    """Levels with the largest numbers that fit their fields get nothing, and spoil nothing."""
    robot, area = fleet.robots[0], fleet.areas(2)[1]
    run = robot.claims.get(area, Claim()).run
    for claim in (Claim(2**32 - 1, 0, 3, 2**64 - 1), Claim(run, 2**32 - 1, 2**32 - 1, 1), Claim(run + 5, 0, 4, 2**62), Claim(run, 7, 2, 1)):
        robot.say(area, claim)
        time.sleep(0.05)
    robot.claims[area] = Claim(run)
    fleet.refused(robot, area, "it was never asked for rightly", page.SILENT_S)
    round_trip(fleet, robot)
    claim = fleet.obtain(robot, area)
    if claim.run > run + 1:
        raise Failed(f"run {run}, as if nothing had been said", found(robot))
