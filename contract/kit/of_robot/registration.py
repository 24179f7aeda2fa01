"""How a robot registers, and what it does when it is refused."""

from __future__ import annotations

import random
import time

from .. import page
from ..floor import area, floor_hash
from ..hall import Hall, Said
from . import SUITE

REPEATS = ("The robot takes over the levels in that answer as its own (it may hold areas since before its restart), and repeats both numbers "
           "in every report.")
ECHO = "It also repeats the `sequence` of the newest message that it has heard, a refusal included, as `mediator_sequence`."
REFUSED = ("the robot keeps what it has, enters nothing, and goes on reporting, with `session` 0 and its `floor`, until it is taken in again.")
TAKEN = "a robot that hears it has no area and no coordination, whatever it had, stops, and goes on asking."


@SUITE.check("repeats-both", REPEATS, "`mediator_instance`, `mediator_journal`, in every report")
def repeats_both(hall: Hall) -> None:
    """Every report repeats epoch, session, instance and journal of the mediator."""
    said = (hall.epoch, hall.session, hall.instance, hall.journal)
    hall.never(hall.watch_s, lambda at: (at.report.mediator_epoch, at.report.session, at.report.mediator_instance,
                                         at.report.mediator_journal) != said, f"epoch, session, instance, journal {said} in every report")


@SUITE.check("new-session", REPEATS)
def new_session(hall: Hall) -> None:
    """A new session number from the same mediator is repeated."""
    with hall.lock:
        hall.session += 1
        hall.robot_sequence = 0
        hall.send()
    hall.expect(hall.soon_s, hall.counts, f"session {hall.session}")


@SUITE.check("echoes-sequence", ECHO)
def echoes_sequence(hall: Hall) -> None:
    """`mediator_sequence` follows the mediator's messages."""
    for _ in range(3):
        hall.send()
        sent = hall.sequence
        hall.expect(hall.soon_s, lambda said, sent=sent: said.report.mediator_sequence >= sent, f"mediator_sequence {sent}")


@SUITE.check("refused-asks-on", REFUSED, ECHO)
def refused_asks_on(hall: Hall) -> None:
    """Refused after a registration it reports on with session 0 and its floor, keeps its areas, and registers again when it may."""
    hall.ahead()
    held = hall.stands_in() & hall.granted
    with hall.lock:
        hall.registers = False
        hall.send()
    expected = floor_hash(hall.floor)
    hall.expect(hall.soon_s, lambda said: said.report.session == 0 and floor_hash(said.report.floor) == expected,
                "session 0, and the floor in its reports")
    sent = hall.sequence
    hall.expect(hall.soon_s, lambda said: said.report.mediator_sequence >= sent, f"mediator_sequence {sent}, of a refusal")

    def lost(said: Said) -> bool:
        return any(name in said.report.stands_in and not (said.access(name) and said.access(name).held) for name in held)

    hall.never(hall.watch_s, lambda said: said.report.session != 0 or lost(said), f"session 0, and {sorted(held)} kept")
    hall.registers = True
    hall.expect(hall.soon_s, hall.counts, "registration when it may")


@SUITE.check("refused-enters-nothing", REFUSED)
def refused_enters_nothing(hall: Hall) -> None:
    """A robot that was granted an area and is then refused does not enter it later."""
    name = hall.ahead()
    with hall.lock:
        hall.let_into(name)
        hall.registers = False
        hall.send()
    # What it could no longer stop before it may still enter.
    time.sleep(page.LEASE_S + page.ENTERS_WITHIN_S)
    before = hall.stands_in()
    hall.never(3.0, lambda said: not set(said.report.stands_in) <= before, f"no area but {sorted(before)}")
    hall.registers = True
    hall.expect(hall.soon_s, hall.counts, "registration when it may")


@SUITE.check("identity-taken", TAKEN, "Only `identity_taken` takes everything from it.")
def identity_taken(hall: Hall) -> None:
    """After `identity_taken` it has no level and no coordination, does not move, and goes on asking."""
    hall.ahead()
    with hall.lock:
        hall.registers = False
        hall.speaks = False
        hall.put(hall.message(identity_taken=True, refusal="another process speaks for this robot"))
        hall.sequence += 1
    hall.expect(hall.soon_s, lambda said: said.report.session == 0 and not said.report.access and not said.report.HasField("control"),
                "session 0, and no level")
    time.sleep(1.0)
    pose = hall.said[-1].report.pose
    hall.never(2.0, lambda said: abs(said.report.pose.x_m - pose.x_m) + abs(said.report.pose.y_m - pose.y_m) > 0.1
               or len(said.report.access) > 0, "a robot that stands, and has nothing")
    with hall.lock:
        hall.levels, hall.registers, hall.speaks = {name: type(own)(own.run + 1) for name, own in hall.levels.items()}, True, True
        hall.session += 1
    hall.expect(hall.soon_s, hall.counts, "registration when it may")


@SUITE.check("refuses-other-floor", "A robot with another floor is refused with the first area that differs, and refuses a mediator likewise.")
def refuses_other_floor(hall: Hall) -> None:
    """A mediator that offers a session and knows another floor is not followed."""
    with hall.lock:
        hall.speaks = False
    other = [*hall.floor, area("elsewhere", 1, 900.0, 900.0, 901.0, 901.0)]
    time.sleep(page.LEVEL_S)
    session, begin = hall.session + 1, len(hall.said)
    for _ in range(5):
        with hall.lock:
            hall.put(hall.message(session=session, floor=other, floor_hash=floor_hash(other), refusal=""))
            hall.sequence += 1
        time.sleep(0.1)
    hall.never(page.SILENT_S, lambda said: said.report.session == session, f"no report with session {session} of a mediator with another floor", since=begin)
    hall.speaks = True
    hall.expect(hall.soon_s, hall.counts, "registration with the right floor")


@SUITE.check("other-version-ignored", "a peer with another major number is refused with a reason (`refusal`), and gets nothing.")
def other_version(hall: Hall) -> None:
    """A session that a mediator of another major version offers is not taken."""
    session, begin = hall.session + 7, len(hall.said)
    for _ in range(3):
        with hall.lock:
            message = hall.message(session=session)
            message.version.major += 1
            hall.put(message)
            hall.sequence += 1
        time.sleep(0.1)
    hall.never(page.SILENT_S, lambda said: said.report.session == session, f"no report with session {session}", since=begin)


@SUITE.check("other-boot-ignored", "A message of a smaller `mediator_epoch`, or for another `boot_epoch`, is from the past: ignore it.")
def other_boot(hall: Hall) -> None:
    """A message for another boot of the robot changes nothing."""
    with hall.lock:
        hall.put(hall.message(boot_epoch=random.getrandbits(64) | 1, session=hall.session + 5, sequence=hall.sequence + 1000))
    hall.never(hall.watch_s, lambda said: not hall.counts(said) or said.report.mediator_sequence >= 1000 + hall.sequence,
               "the registration as it was")


@SUITE.check("other-robot-ignored", "A robot subscribes to its own `PREFIX/mediator/to/ID`",
             "| `PREFIX/mediator/to/ID` | `MediatorReport` | mediator, to one robot |")
def other_robot(hall: Hall) -> None:
    """A message with another robot's id on its key changes nothing."""
    with hall.lock:
        hall.put(hall.message(robot_id=hall.robot_id + "-other", session=hall.session + 5, sequence=hall.sequence + 1000))
    hall.never(hall.watch_s, lambda said: not hall.counts(said) or said.report.mediator_sequence >= 1000 + hall.sequence,
               "the registration as it was")
