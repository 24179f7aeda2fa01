"""Bytes that no mediator means: the robot must not feel them."""

from __future__ import annotations

import random
import time

from .. import page, wire
from ..checks import Failed
from ..hall import Hall
from . import SUITE

FLOOD_S = 3.0
LEVELS = "Messages are *levels, not edges*: each carries all there is to know, so a lost, repeated or late one does no harm."


def hears(hall: Hall, backlog_s: float = 0.0) -> None:
    """That the robot takes in the mediator's next message, once it is through what came before."""
    with hall.lock:
        hall.send()
        sent = hall.sequence
    hall.expect(hall.soon_s + backlog_s, lambda said: said.report.mediator_sequence >= sent and hall.counts(said), f"mediator_sequence {sent}")


@SUITE.check("unknown-fields", "Unknown fields are to be ignored, so that minor versions may add some.")
def unknown_fields(hall: Hall) -> None:
    """A message of a later minor version with unknown fields is taken in like any other."""
    with hall.lock:
        hall.speaks = False
        message = hall.message()
        message.version.minor = page.VERSION[1] + 9
        hall.sequence += 1
        sent = hall.sequence
        hall.put(message, wire.unknown_field(777, 40))
    hall.expect(hall.soon_s, lambda said: said.report.mediator_sequence >= sent and hall.counts(said), f"mediator_sequence {sent}")
    hall.speaks = True


@SUITE.check("malformed-bytes", LEVELS)
def malformed_bytes(hall: Hall) -> None:
    """Bytes that are no message change nothing."""
    draw, whole = random.Random(3), hall.message().SerializeToString()
    key = f"{hall.prefix}/mediator/to/{hall.robot_id}"
    for _ in range(100):
        hall.network.put(key, bytes(draw.getrandbits(8) for _ in range(draw.randrange(1, 80))))
        hall.network.put(key, b"\xff" + whole[:draw.randrange(len(whole))])
    hall.network.put(key, b"")
    hears(hall)


@SUITE.check("oversized-dropped", "Messages above 1 MiB are dropped on both sides.")
def oversized(hall: Hall) -> None:
    """A message above 1 MiB, right but for its length, is not taken in."""
    with hall.lock:
        hall.speaks = False
        # Later than all that come.
        message = hall.message(sequence=hall.sequence + 1000)
        hall.put(message, wire.unknown_field(999, wire.LONGEST_MESSAGE))
    hall.never(page.SILENT_S * 0.8, lambda said: said.report.mediator_sequence >= message.sequence, "a message of over 1 MiB dropped")
    hall.speaks = True
    hears(hall)


@SUITE.check("flood", LEVELS, "| a level is sent at least every | 200 ms |")
def flood(hall: Hall) -> None:
    """For 3 s a thousand messages a second of noise, of other boots and of other mediators: it reports on, and follows whom it followed."""
    draw, key = random.Random(4), f"{hall.prefix}/mediator/to/{hall.robot_id}"
    begin, sent = time.monotonic(), 0
    while (now := time.monotonic()) < begin + FLOOD_S:
        if sent > (now - begin) * 1000:
            time.sleep(0.002)
            continue
        sent += 1
        kind = draw.randrange(3)
        if kind == 0:
            hall.network.put(key, bytes(draw.getrandbits(8) for _ in range(60)))
        elif kind == 1:
            hall.put(hall.message(boot_epoch=draw.getrandbits(64), session=draw.getrandbits(62)))
        else:
            hall.put(hall.message(instance=draw.getrandbits(64), journal=draw.getrandbits(64), mediator_epoch=hall.epoch + draw.randrange(5)))
    times = [begin, *(said.at for said in hall.said if said.at > begin), time.monotonic()]
    gap = max(later - earlier for earlier, later in zip(times, times[1:]))
    if gap > page.SILENT_S:
        raise Failed(f"reports at least every {page.SILENT_S:.0f} s all the while", f"a gap of {gap:.2f} s")
    # A robot beside busy programs may need as long again for what has come.
    hears(hall, FLOOD_S)


@SUITE.check("unknown-area-ignored", "Robots and mediator must know the same areas.")
def unknown_area(hall: Hall) -> None:
    """Levels and revocations of an area that the floor does not have spoil nothing."""
    with hall.lock:
        message = hall.message()
        hall.sequence += 1
        for entries in (message.access, message.revocations):
            entry = entries.add(area="no-such-area", fence=2**63)
            entry.level.run, entry.level.path, entry.level.progress = 2**31, 2**31, 2**31
        hall.put(message)
    hears(hall)
    hall.ahead()
