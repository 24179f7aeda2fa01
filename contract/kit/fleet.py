"""The surroundings of a check of a mediator: all robots of its site, played by the kit."""

from __future__ import annotations

import random
import threading
import time
from dataclasses import dataclass
from typing import Any, Callable, Sequence

from . import floor, page, wire
from .checks import Failed, Mute, Skipped
from .network import Network
from .played_robot import Claim, Heard, PlayedRobot
from .program import Program


# Until a program listens and its peers have found it, beside the margin.
STARTS_S = 8.0


@dataclass(frozen=True)
class Settings:
    """What the command line says of the mediator."""

    prefix: str
    site: str
    robots: Sequence[str]
    areas: Sequence[str]
    coordinated: Sequence[str]
    margin_s: float


class Fleet:
    """All robots of the site, each a fresh process for each check."""

    def __init__(self, network: Network, settings: Settings, program: Program | None) -> None:
        self.network, self.settings, self.program = network, settings, program
        self.floor: list[Any] = []
        self.robots: list[PlayedRobot] = []
        # Epoch and sequence of all messages to an identity, to whichever boot.
        self.heard_by_id: dict[str, list[tuple[int, int]]] = {}
        # When each process of the mediator was heard first under each of its epochs.
        self.met_at: dict[tuple[int, int], float] = {}
        # Of all messages so far, bytes.
        self.longest = 0
        self._all: list[PlayedRobot] = []
        # The mediator has just started, and counts the time until it believes processes that it does not know; and it is to start anew.
        self._starts, self._broken = True, False
        self._ends = threading.Event()
        # Something that changes is said with the next level at the latest.
        self.soon_s = page.LEVEL_S + settings.margin_s
        # For so long it is watched that something does not happen.
        self.watch_s = 5 * page.LEVEL_S + settings.margin_s / 2
        # A process before may have held what it had not entered.
        self.taken_in_s = page.ENTERS_NO_MORE_S + page.LEVEL_S + settings.margin_s
        network.subscribe(f"{settings.prefix}/mediator/to/*", self._take)
        self._thread = threading.Thread(target=self._tick, daemon=True)
        self._thread.start()

    def _take(self, key: str, data: bytes) -> None:
        robot_id = key.rsplit("/", 1)[-1]
        self.longest = max(self.longest, len(data))
        message: Any = wire.decode(wire.MediatorReport, data)
        if message is not None:
            self.heard_by_id.setdefault(robot_id, []).append((message.mediator_epoch, message.sequence))
            self.met_at.setdefault((message.instance, message.mediator_epoch), time.monotonic())
        for robot in list(self._all):
            if robot.robot_id == robot_id:
                robot.take(data)

    def _tick(self) -> None:
        while not self._ends.wait(0.02):
            for robot in list(self._all):
                robot.tick()

    def close(self) -> None:
        """Nobody speaks any more."""
        self._ends.set()
        self._thread.join()

    # ------------------------------------------------------------ around a check

    def provide(self, needs: Sequence[str]) -> None:
        """Skips the check where something is missing that it takes."""
        if "--start" in needs and self.program is None:
            raise Skipped("it restarts the mediator: give --start 'COMMAND'")
        if "--coordinated" in needs and not self.settings.coordinated:
            raise Skipped("it needs a coordination: give --coordinated ROBOT:STATE:AREA")
        for need, count in (("2 robots", 2), ("3 robots", 3)):
            if need in needs and len(self.settings.robots) < count:
                raise Skipped(f"the site needs {need}, and --robots names {len(self.settings.robots)}")

    def prepare(self, fresh: bool) -> None:
        """A fresh process for each robot, registered, that stands nowhere and has nothing, and may be granted something."""
        if self._broken and self.program is not None and not fresh:
            self.restart(anew=True)
        self._broken = False
        if not self.floor:
            self._ask_for_floor()
        self._all.clear()
        if fresh:
            return
        self.robots = [self.process(robot_id) for robot_id in self.settings.robots]
        for robot in self.robots:
            self.join(robot)
        if self._starts:
            self.believed()
            self._starts = False

    def tidy(self, outcome: str) -> None:
        """Everybody gives back what it has, and falls silent."""
        for robot in self.robots:
            if robot.speaks and robot.session:
                robot.give_back_all()
                robot.fsm_state = "idle"
        if outcome != "skipped":
            time.sleep(page.LEVEL_S)
        for robot in self.robots:
            # A coordination that was begun is played to its end, so that it holds nobody.
            if robot.newest is not None:
                robot.wait(4 * self.soon_s, lambda heard: not heard.message.HasField("control"))
        for robot in self._all:
            robot.speaks = False
        self.robots = []
        self._broken |= outcome == "FAILED"

    def process(self, robot_id: str, speaks: bool = True) -> PlayedRobot:
        """A process of a robot that has just started."""
        robot = PlayedRobot(self.network, self.settings.prefix, robot_id, self.settings.site, self.floor)
        robot.speaks = speaks
        self._all.append(robot)
        return robot

    def _ask_for_floor(self) -> None:
        asks = PlayedRobot(self.network, self.settings.prefix, self.settings.robots[0], self.settings.site, [])
        self._all.append(asks)
        seconds = 10.0 + self.settings.margin_s
        heard = asks.wait(seconds, lambda heard: len(heard.message.floor) > 0)
        asks.speaks = False
        if heard is None and asks.newest is None:
            words = self.program.last_words() if self.program is not None else ""
            raise Mute(f"the mediator never speaks: nothing on {self.settings.prefix}/mediator/to/{asks.robot_id} within {seconds:.0f} s "
                       f"after reports of that robot. {words}".rstrip())
        if heard is None:
            raise Mute(f"the mediator never sends its floor to a robot that has none; it says `{asks.newest.message.refusal}`")
        self.floor = list(heard.message.floor)

    def register(self, robot: PlayedRobot) -> None:
        """Waits until the robot is registered."""
        starts_s = max(0.0, self.program.started_at + STARTS_S - time.monotonic()) if self.program is not None else 0.0
        # That it is in time is for checks to judge, not for what surrounds them.
        patience_s = starts_s + self.taken_in_s + page.CANDIDATE_S
        self.expect(robot, patience_s, lambda heard: heard.message.session != 0, "a session for a robot of the site whose process before is silent")

    def join(self, robot: PlayedRobot) -> None:
        """Waits until the robot is registered, and all are believed, so that its reports count."""
        self.register(robot)
        self.expect(robot, self.taken_in_s + page.CANDIDATE_S, lambda heard: heard.message.robot_sequence > 0, "reports that count")
        if robot.claims:
            # Levels of a run before, which was left where it was.
            robot.give_back_all()
            robot.wait(self.soon_s, lambda heard: all(claim.progress == 0 for claim in robot.claims.values()))

    def believed(self) -> None:
        """Waits until a mediator that has just started, or taken a larger epoch, believes processes that it did not know then, and each of
        them has heard it since."""
        said = self.robots[0].messages[-1].message
        met_at = self.met_at[said.instance, said.mediator_epoch]
        time.sleep(max(0.0, met_at + page.ENTERS_NO_MORE_S + 3 * page.LEVEL_S - time.monotonic()))

    def restart(self, anew: bool = False, go_on: bool = False) -> None:
        """Restarts the mediator, `anew` with an empty journal. The robots' processes go on, or end with it."""
        assert self.program is not None
        # It believes processes that its journal knows at once.
        self._starts |= anew or not go_on
        if not go_on:
            for robot in self._all:
                robot.speaks = False
            self._all.clear()
            self.robots = []
        self.program.start(anew=anew)

    # ------------------------------------------------------------ areas

    def areas(self, count: int, capacity: int = 1) -> list[str]:
        """Names of areas that hold so many."""
        listed = self.settings.areas or [area.id for area in self.floor]
        found = [area.id for area in self.floor if area.id in listed and area.capacity == capacity]
        if len(found) < count:
            raise Skipped(f"the site needs {count} areas that hold {capacity}")
        return found[:count]

    # ------------------------------------------------------------ judging

    def expect(self, robot: PlayedRobot, seconds: float, until: Callable[[Heard], bool], expected: str) -> Heard:
        """The first message of which this is true; a failure when there is none in time."""
        heard = robot.wait(seconds, until)
        if heard is None:
            raise Failed(f"{expected}, within {seconds:.1f} s", found(robot))
        return heard

    def never(self, robot: PlayedRobot, seconds: float, until: Callable[[Heard], bool], expected: str) -> None:
        """A failure when this is true of a message in that time, or when no message comes at all."""
        begin = len(robot.messages)
        if robot.wait(seconds, until) is not None:
            raise Failed(f"{expected}, for {seconds:.1f} s", found(robot))
        if len(robot.messages) == begin:
            raise Failed(f"messages to {robot.robot_id} all the while", f"none in {seconds:.1f} s")

    def obtain(self, robot: PlayedRobot, area: str) -> Claim:
        """Asks for a free area, and waits for its grant."""
        robot.request(area)
        return self.granted(robot, area)

    def granted(self, robot: PlayedRobot, area: str) -> Claim:
        """The grant of an area that was asked for."""
        heard = self.expect(robot, self.soon_s, holds(area), f"a grant of {area} to {robot.robot_id}")
        claim = heard.access(area)
        assert claim is not None
        return claim

    def refused(self, robot: PlayedRobot, area: str, why: str, seconds: float | None = None) -> None:
        """That an area is not granted."""
        self.never(robot, seconds or self.watch_s, holds(area), f"no grant of {area} to {robot.robot_id}: {why}")

    def another_boot(self) -> int:
        """A number that no process has drawn."""
        return random.getrandbits(64) | 1

    def changed_floor(self, index: int) -> list[Any]:
        """The floor, but the areas from this one on hold one more each."""
        areas = sorted(self.floor, key=lambda area: area.id.encode())
        return [floor.area(own.id, own.capacity + (at >= index), own.min_x_m, own.min_y_m, own.max_x_m, own.max_y_m)
                for at, own in enumerate(areas)]


def holds(area: str) -> Callable[[Heard], bool]:
    """Whether a message says that the robot has the area."""
    def judge(heard: Heard) -> bool:
        claim = heard.access(area)
        return claim is not None and claim.held

    return judge


def at_progress(area: str, run: int, progress: int) -> Callable[[Heard], bool]:
    """Whether a message says that the array of an area is so far."""
    def judge(heard: Heard) -> bool:
        claim = heard.access(area)
        return claim is not None and (claim.run, claim.progress) == (run, progress)

    return judge


def found(robot: PlayedRobot) -> str:
    """The newest message to a robot, as a failure shows it."""
    newest = robot.newest
    if newest is None:
        return f"no message to {robot.robot_id}"
    message = newest.message
    levels = ", ".join(f"{entry.area} {entry.level.run}/{entry.level.path}/{entry.level.progress} fence {entry.fence}"
                       + (f" ({entry.waits_for})" if entry.waits_for else "") for entry in message.access)
    control = f", control {message.control.coordination} at {message.control.level.progress}" if message.HasField("control") else ""
    refusal = f", refusal `{message.refusal}`" if message.refusal else ""
    return (f"to {robot.robot_id}: epoch {message.mediator_epoch}, session {message.session}, sequence {message.sequence}, "
            f"robot_sequence {message.robot_sequence}{refusal}, levels [{levels}]{control}")
