"""A robot played by the kit: it says what a check wants it to, and otherwise what is right."""

from __future__ import annotations

import math
import random
import threading
import time
from dataclasses import dataclass
from typing import Any, Callable

from . import page, wire
from .floor import floor_hash
from .network import Network


@dataclass(frozen=True)
class Claim:
    """A level of protocol 1 with its fence."""

    run: int = 0
    path: int = 0
    progress: int = 0
    fence: int = 0

    @property
    def held(self) -> bool:
        """Granted, and neither released nor returned."""
        return self.path == 0 and self.progress in (2, 3)

    def then(self, progress: int, path: int = 0) -> Claim:
        """Further in the same run, of the same grant."""
        return Claim(self.run, path, progress, self.fence)


@dataclass(frozen=True)
class Heard:
    """A message of the mediator, and when it came."""

    at: float
    message: Any

    def access(self, area: str) -> Claim | None:
        """The level of an area, if the message has one."""
        return next((claim_of(entry) for entry in self.message.access if entry.area == area), None)

    def revocation(self, area: str) -> Claim | None:
        """The level of a revocation, if the message has one."""
        return next((claim_of(entry) for entry in self.message.revocations if entry.area == area), None)


def claim_of(entry: Any) -> Claim:
    """The level in an `Access` or an `AccessGrant`."""
    return Claim(entry.level.run, entry.level.path, entry.level.progress, entry.fence)


class PlayedRobot:
    """One process of one robot. All of it is under `lock`, which is also told of each message."""

    def __init__(self, network: Network, prefix: str, robot_id: str, site: str, areas: list[Any]) -> None:
        self.network, self.robot_id, self.site, self.areas = network, robot_id, site, areas
        self.key = f"{prefix}/robots/{robot_id}/report"
        self.lock = threading.Condition(threading.RLock())
        self.boot_epoch = random.getrandbits(64) | 1
        self.version = page.VERSION
        self.hash = floor_hash(areas)
        self.sequence = self.mediator_epoch = self.session = self.echo = self.instance = self.journal = 0
        self.located, self.pose, self.fsm_state = True, (0.0, 0.0), "idle"
        self.without_control = False
        self.stands_in: list[str] = []
        self.claims: dict[str, Claim] = {}
        self.revocations: dict[str, Claim] = {}
        self.control: tuple[int, int, int] | None = None
        self.messages: list[Heard] = []
        self.speaks = self.follows = self.plays_along = True
        self._sent_at = 0.0
        # By the mediator's instance.
        self._heard_at: dict[int, float] = {}

    # ------------------------------------------------------------ sending

    def report(self) -> Any:
        """The next report."""
        self.sequence += 1
        report = wire.RobotReport(
            robot_id=self.robot_id, boot_epoch=self.boot_epoch, sequence=self.sequence, site=self.site,
            mediator_epoch=self.mediator_epoch, session=self.session, stands_in=self.stands_in, located=self.located,
            fsm_state=self.fsm_state, mediator_sequence=self.echo, mediator_instance=self.instance,
            mediator_heard=self.hears(), mediator_journal=self.journal, floor_hash=self.hash,
            without_control=self.without_control)
        report.version.major, report.version.minor = self.version
        report.pose.x_m, report.pose.y_m = self.pose
        if self.session == 0:
            report.floor.extend(self.areas)
        for claims, field in ((self.claims, report.access), (self.revocations, report.revocations)):
            for name, claim in claims.items():
                entry = field.add(area=name, fence=claim.fence)
                entry.level.run, entry.level.path, entry.level.progress = claim.run, claim.path, claim.progress
        if self.control is not None:
            report.control.coordination = self.control[0]
            report.control.level.path, report.control.level.progress = self.control[1:]
        return report

    def send(self, data: bytes | None = None) -> int:
        """Sends a report at once; these bytes, if given. Returns its sequence."""
        with self.lock:
            self._sent_at = time.monotonic()
            self.network.put(self.key, self.report().SerializeToString() if data is None else data)
            return self.sequence

    def tick(self) -> None:
        """Sends a report when the last one is old."""
        with self.lock:
            if self.speaks and time.monotonic() >= self._sent_at + page.LEVEL_S * 0.8:
                self.send()

    def hears(self) -> bool:
        """Whether a message of the mediator that it follows has come of late."""
        return time.monotonic() <= self._heard_at.get(self.instance, -math.inf) + page.SILENT_S

    # ------------------------------------------------------------ hearing

    def take(self, data: bytes) -> None:
        """Takes in the bytes of a message to this identity."""
        message: Any = wire.decode(wire.MediatorReport, data)
        with self.lock:
            if message is None or message.boot_epoch != self.boot_epoch:
                return
            self.messages.append(Heard(time.monotonic(), message))
            if self.follows and self.speaks:
                self._follow(message)
            self._heard_at[message.instance] = time.monotonic()
            self.lock.notify_all()

    def _follow(self, message: Any) -> None:
        before = (self.mediator_epoch, self.session, self.instance, self.claims, self.revocations, self.control)
        if (message.mediator_epoch, message.sequence) <= (self.mediator_epoch, self.echo):
            return
        self.echo, self.mediator_epoch = message.sequence, message.mediator_epoch
        self.instance, self.journal, self.session = message.instance, message.journal, message.session
        if message.session == 0:
            return
        self.claims, self.revocations = dict(self.claims), dict(self.revocations)
        for entry in message.access:
            own, theirs = self.claims.get(entry.area, Claim()), claim_of(entry)
            if (theirs.run, theirs.progress) > (own.run, own.progress):
                self.claims[entry.area] = theirs
        for entry in message.revocations:
            own, theirs = self.revocations.get(entry.area, Claim()), claim_of(entry)
            if (theirs.run, theirs.progress) > (own.run, own.progress):
                self.revocations[entry.area] = theirs
        self._follow_control(message)
        if before != (self.mediator_epoch, self.session, self.instance, self.claims, self.revocations, self.control):
            self.send()

    def _follow_control(self, message: Any) -> None:
        if not message.HasField("control"):
            self.control = None
            return
        control = message.control
        own = self.control if self.control is not None and self.control[0] == control.coordination else None
        path, progress = control.level.path, control.level.progress
        if own is None or progress > own[2]:
            self.control = (control.coordination, path, progress)
        following = next_flag(control, *self.control[1:]) if self.control else None
        if self.plays_along and self.control and following is not None and not following.by_mediator:
            self.control = (self.control[0], self.control[1], self.control[2] + 1)

    # ------------------------------------------------------------ what a robot does

    def say(self, area: str, claim: Claim) -> int:
        """Reports a level of an area, right or wrong."""
        with self.lock:
            self.claims[area] = claim
            return self.send()

    def request(self, area: str) -> int:
        """Asks for an area, unless its run is under way."""
        with self.lock:
            own = self.claims.get(area, Claim())
            return self.say(area, own if own.progress > 0 else own.then(1))

    def enter(self, area: str) -> int:
        """Reaches into an area that was granted."""
        with self.lock:
            self.stands_in = [*self.stands_in, area]
            return self.say(area, self.claims[area].then(3))

    def leave(self, area: str) -> int:
        """Leaves an area that it has entered."""
        with self.lock:
            self.stands_in = [other for other in self.stands_in if other != area]
            return self.say(area, self.claims[area].then(4))

    def give_back(self, area: str) -> int:
        """Gives back a grant that it has not entered."""
        return self.say(area, self.claims[area].then(3, path=1))

    def give_back_all(self) -> None:
        """Releases and returns all that it has, and stands nowhere."""
        with self.lock:
            self.stands_in, self.plays_along, self.located = [], True, True
            for area, claim in self.claims.items():
                if claim.path == 0 and claim.progress == 2:
                    self.claims[area] = claim.then(3, path=1)
                elif claim.path == 0 and claim.progress == 3:
                    self.claims[area] = claim.then(4)
            for area, claim in self.revocations.items():
                if claim.progress == 1:
                    self.revocations[area] = claim.then(2)
            self.send()

    @property
    def newest(self) -> Heard | None:
        """The message that came last."""
        with self.lock:
            return self.messages[-1] if self.messages else None

    def wait(self, seconds: float, until: Callable[[Heard], bool]) -> Heard | None:
        """The first of the messages from now on, the newest included, of which this is true; None when time is over."""
        end = time.monotonic() + seconds
        with self.lock:
            at = max(len(self.messages) - 1, 0)
            while True:
                for heard in self.messages[at:]:
                    if until(heard):
                        return heard
                at = len(self.messages)
                left = end - time.monotonic()
                if left <= 0:
                    return None
                self.lock.wait(left)


def next_flag(control: Any, path: int, progress: int) -> Any | None:
    """The flag that is set next on that path of a coordination; None behind the last."""
    order = list(control.paths[path].flags) if path < len(control.paths) else list(range(len(control.flags)))
    return control.flags[order[progress]] if progress < len(order) else None
