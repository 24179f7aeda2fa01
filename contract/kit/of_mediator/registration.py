"""Who is taken in, and what every message carries."""

from __future__ import annotations

import math
import re
import time

from .. import page, wire
from ..checks import Failed
from ..fleet import Fleet, found
from ..floor import HASH_OF_NOTHING, floor_hash
from ..played_robot import PlayedRobot
from . import SUITE

OTHER_VERSION = "a peer with another major number is refused with a reason (`refusal`), and gets nothing."
REFUSALS = ("The mediator answers with its own `mediator_epoch`, which grows at least with every start of a mediator, and a `session`, "
            "which grows with every boot of that robot, and is none that an earlier epoch may have given out; or with a `refusal`: unknown identity, "
            "other site, other floor, other version.")
ECHO = ("Every `MediatorReport` echoes in `robot_sequence` the `sequence` of the newest report that counted: of this boot, session and "
        "epoch; or 0, while the mediator gives it no lease.")


def silenced(fleet: Fleet, index: int = 0) -> str:
    """The identity of a robot whose process has just ended."""
    robot = fleet.robots[index]
    robot.speaks = False
    time.sleep(page.SILENT_S + page.LEVEL_S)
    return robot.robot_id


def refused(fleet: Fleet, robot: PlayedRobot, why: str) -> str:
    """That the process is refused with a reason, and gets nothing. Returns the reason."""
    heard = fleet.expect(robot, fleet.soon_s, lambda heard: heard.message.refusal != "", f"a refusal: {why}")
    fleet.never(robot, fleet.watch_s, lambda heard: heard.message.session != 0 or len(heard.message.access) > 0,
                f"no session and no levels: {why}")
    return str(heard.message.refusal)


@SUITE.check("first-answer", REFUSALS)
def first_answer(fleet: Fleet) -> None:
    """A report without a registration is answered with epoch and session, and with this robot's id and boot."""
    robot = fleet.process(silenced(fleet))
    heard = fleet.expect(robot, fleet.soon_s, lambda heard: heard.message.session != 0, "a session")
    message = heard.message
    if message.mediator_epoch < 1 or message.robot_id != robot.robot_id or message.version.major != page.VERSION[0]:
        raise Failed(f"epoch 1 or larger, robot_id {robot.robot_id}, version {page.VERSION[0]}", str(message))


@SUITE.check("version-refused", OTHER_VERSION)
def version_refused(fleet: Fleet) -> None:
    """A robot of an older or newer major version is refused with a reason."""
    identity = silenced(fleet)
    for major in (page.VERSION[0] - 1, page.VERSION[0] + 1):
        robot = fleet.process(identity)
        robot.version = (major, 0)
        refused(fleet, robot, f"version {major}.0")
        robot.speaks = False


@SUITE.check("newer-minor-welcome", "Unknown fields are to be ignored, so that minor versions may add some.")
def newer_minor_welcome(fleet: Fleet) -> None:
    """A robot of a later minor version with unknown fields in its reports is served like any other."""
    robot = fleet.robots[0]
    robot.version = (page.VERSION[0], page.VERSION[1] + 9)
    area, = fleet.areas(1)
    with robot.lock:
        report = robot.report()
        entry = report.access.add(area=area)
        entry.level.progress = 1
        robot.speaks = False
        entry.level.run = robot.claims[area].run if area in robot.claims else 0
        robot.send(report.SerializeToString() + wire.unknown_field(777, 40))
    fleet.granted(robot, area)
    robot.speaks = True


@SUITE.check("unknown-identity", REFUSALS)
def unknown_identity(fleet: Fleet) -> None:
    """A robot that the site does not list is refused."""
    robot = fleet.process("nobody-" + str(fleet.another_boot() % 10**6))
    refused(fleet, robot, "an identity that is not of the site")


@SUITE.check("other-site", REFUSALS)
def other_site(fleet: Fleet) -> None:
    """A robot of another site is refused."""
    robot = fleet.process(silenced(fleet))
    robot.site += "-elsewhere"
    refused(fleet, robot, "another site")


@SUITE.check("other-floor", "A robot with another floor is refused with the first area that differs")
def other_floor(fleet: Fleet) -> None:
    """A robot whose areas differ from the second one on is refused with the name of that one."""
    robot = fleet.process(silenced(fleet))
    robot.areas = fleet.changed_floor(min(1, len(fleet.floor) - 1))
    robot.hash = floor_hash(robot.areas)
    reason = refused(fleet, robot, "another floor")
    names = [area.id for area in robot.areas]
    first = names[min(1, len(names) - 1)]
    words = re.findall(r"[\w.-]+", reason.split(" by ")[0])
    if first not in words:
        raise Failed(f"a refusal that names area {first}", reason)


@SUITE.check("floor-served", "it takes the list from the refusal, and repeats that hash from then on.",
             "while its reports do not carry the mediator's hash, so do messages to it.")
def floor_served(fleet: Fleet) -> None:
    """A robot without a site file gets all areas, and is taken in once it repeats their hash."""
    robot = fleet.process(silenced(fleet))
    robot.areas, robot.hash = [], HASH_OF_NOTHING
    heard = fleet.expect(robot, fleet.soon_s, lambda heard: len(heard.message.floor) > 0, "a message with the floor")
    robot.areas = list(heard.message.floor)
    robot.hash = floor_hash(robot.areas)
    if robot.hash != heard.message.floor_hash:
        raise Failed(f"floor_hash of the list, {robot.hash:016x}", f"{heard.message.floor_hash:016x}")
    fleet.expect(robot, fleet.soon_s, lambda heard: heard.message.session != 0, "a session for the robot that repeats the hash")


@SUITE.check("floor-hash", "Every report and every message to a robot that is taken in carries `floor_hash`")
def floor_hash_in_all(fleet: Fleet) -> None:
    """Every message to a registered robot carries the hash of the floor."""
    robot, expected = fleet.robots[0], floor_hash(fleet.floor)
    fleet.never(robot, fleet.watch_s, lambda heard: heard.message.floor_hash != expected, f"floor_hash {expected:016x} in every message")


@SUITE.check("level-rate", "| a level is sent at least every | 200 ms |")
def level_rate(fleet: Fleet) -> None:
    """Messages come every 200 ms although nothing changes."""
    robot = fleet.robots[0]
    begin, seconds = time.monotonic(), 3.0
    time.sleep(seconds)
    times = [begin, *(heard.at for heard in robot.messages if heard.at > begin), begin + seconds]
    gap = max(later - earlier for earlier, later in zip(times, times[1:]))
    least = int(seconds / page.LEVEL_S * 0.8)
    if len(times) - 2 < least or gap > page.LEVEL_S + fleet.settings.margin_s / 2:
        raise Failed(f"at least {least} messages in {seconds:.0f} s, no gap above {page.LEVEL_S + fleet.settings.margin_s / 2:.1f} s",
                     f"{len(times) - 2} messages, the largest gap {gap:.2f} s")


@SUITE.check("sequence-by-one", "| `sequence` of a report, of a message to a robot | 1 | by one with each, in one epoch | 2^62 |")
def sequence_by_one(fleet: Fleet) -> None:
    """The numbers of messages to one robot grow by one."""
    robot = fleet.robots[0]
    fleet.heard_by_id.clear()
    time.sleep(fleet.watch_s)
    numbers = [sequence for epoch, sequence in fleet.heard_by_id.get(robot.robot_id, []) if epoch == robot.mediator_epoch]
    if len(numbers) < 3 or any(later != earlier + 1 for earlier, later in zip(numbers, numbers[1:])):
        raise Failed("sequences that grow by one", f"{numbers}")


@SUITE.check("robot-sequence", ECHO)
def robot_sequence(fleet: Fleet) -> None:
    """`robot_sequence` follows the robot's reports, and never runs ahead of them."""
    robot = fleet.robots[0]
    for _ in range(3):
        sent = robot.send()
        fleet.expect(robot, fleet.soon_s, lambda heard, sent=sent: heard.message.robot_sequence >= sent, f"robot_sequence {sent}")
        if robot.messages[-1].message.robot_sequence > robot.sequence:
            raise Failed(f"at most {robot.sequence}, the newest that was sent", found(robot))


@SUITE.check("uncounted-not-echoed", ECHO)
def uncounted_not_echoed(fleet: Fleet) -> None:
    """Reports with another session or epoch do not move `robot_sequence`, so that they give no lease."""
    robot = fleet.robots[0]
    for name in ("session", "mediator_epoch"):
        robot.speaks, right = False, getattr(robot, name)
        time.sleep(0.1)
        # Registrations that were, or never were; not larger, since that tells of a lie in the mediator's name.
        setattr(robot, name, right - 1)
        last = robot.sequence
        for _ in range(3):
            robot.send()
            time.sleep(page.LEVEL_S / 2)
        fleet.never(robot, fleet.soon_s, lambda heard, last=last: heard.message.robot_sequence > last,
                    f"robot_sequence at most {last} after reports with {name} {right - 1}")
        setattr(robot, name, right)
        robot.speaks = True
        fleet.expect(robot, fleet.soon_s, lambda heard, last=last: heard.message.robot_sequence > last, "reports that count again")


@SUITE.check("message-size", "A message has at most 1048576 bytes.")
def message_size(fleet: Fleet) -> None:
    """No message of the mediator is longer."""
    time.sleep(page.SILENT_S)
    if fleet.longest > wire.LONGEST_MESSAGE:
        raise Failed(f"at most {wire.LONGEST_MESSAGE} bytes", f"{fleet.longest}")


@SUITE.check("alive-token", "| `PREFIX/mediator/alive` | liveliness token | mediator | as long as its session lives |")
def alive_token(fleet: Fleet) -> None:
    """The liveliness token is there."""
    key = f"{fleet.settings.prefix}/mediator/alive"
    if not fleet.network.is_alive(key):
        raise Failed(f"a token {key}", "none")


@SUITE.check("factsheet-counts", "`factsheet`, in its reports until the mediator has one of them")
def factsheet_counts(fleet: Fleet) -> None:
    """A report with a factsheet counts like any other, whatever is in it: a long text, a number that is none, a protocol that nobody knows."""
    robot = fleet.robots[0]
    with robot.lock:
        robot.speaks = False
        report = robot.report()
        report.factsheet.manufacturer, report.factsheet.model = "somebody", "x" * 5000
        report.factsheet.front_m, report.factsheet.max_speed_m_s = math.nan, math.inf
        report.factsheet.protocols.extend([1, 2, 2**31])
        robot.network.put(robot.key, report.SerializeToString())
    fleet.expect(robot, fleet.soon_s, lambda heard: heard.message.robot_sequence >= report.sequence, f"robot_sequence {report.sequence}")
    robot.speaks = True


@SUITE.check("take-up", "answers carry in `take_up` the state of its machine as the mediator knows it, and the pose if this process of the "
             "mediator has heard it.")
def take_up(fleet: Fleet) -> None:
    """A new process of a robot, not yet located, is told state and pose of the one before."""
    old = fleet.robots[0]
    old.pose, old.fsm_state = (1.25, -0.5), "call"
    sent = old.send()
    fleet.expect(old, fleet.soon_s, lambda heard: heard.message.robot_sequence >= sent, f"robot_sequence {sent}")
    robot = fleet.process(silenced(fleet), speaks=False)
    robot.located, robot.speaks = False, True
    heard = fleet.expect(robot, fleet.soon_s, lambda heard: heard.message.session != 0, "a session")
    said = heard.message.take_up
    if said.fsm_state != "call" or (said.pose.x_m, said.pose.y_m) != (1.25, -0.5):
        raise Failed("take_up with state `call` and pose (1.25, -0.5)", f"{said}".replace("\n", " ") or "no take_up")
    robot.located = True
    robot.send()
