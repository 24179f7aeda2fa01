"""The surroundings of a check of a robot: a mediator, played by the kit, with one robot."""

from __future__ import annotations

import random
import threading
import time
from dataclasses import dataclass
from typing import Any, Callable, Sequence

from . import page, wire
from .checks import Failed, Mute, Skipped
from .floor import HASH_OF_NOTHING, floor_hash, row
from .network import Network
from .played_robot import Claim, claim_of
from .program import Program


@dataclass(frozen=True)
class Said:
    """A report of the robot, and when it came."""

    at: float
    report: Any

    def access(self, area: str) -> Claim | None:
        """The level of an area, if the report has one."""
        return next((claim_of(entry) for entry in self.report.access if entry.area == area), None)

    def revocation(self, area: str) -> Claim | None:
        """The answer to a revocation, if the report has one."""
        return next((claim_of(entry) for entry in self.report.revocations if entry.area == area), None)


class Hall:
    """A mediator for one robot. What it knows of areas outlives its restarts, as in a journal. All of it is under `lock`."""

    def __init__(self, network: Network, prefix: str, site: str, robot_id: str, margin_s: float, patience_s: float,
                 program: Program | None) -> None:
        self.network, self.prefix, self.site, self.robot_id, self.program = network, prefix, site, robot_id, program
        self.margin_s, self.patience_s = margin_s, patience_s
        self.soon_s = page.LEVEL_S + margin_s
        self.watch_s = 5 * page.LEVEL_S + margin_s / 2
        self.lock = threading.Condition(threading.RLock())
        self.said: list[Said] = []
        # Of all reports so far, bytes.
        self.longest = 0
        self.states: list[tuple[float, Any]] = []
        self.floor: list[Any] = []
        self.epoch, self.journal = 0, random.getrandbits(64) | 1
        self.instance = self.boot_epoch = self.session = self.sequence = self.robot_sequence = 0
        self.levels: dict[str, Claim] = {}
        self.fences: dict[str, int] = {}
        # The run of each area's next revocation: robots may leave out those that they have answered.
        self.next_revocation: dict[str, int] = {}
        self.granted: set[str] = set()
        # Of the last coordination.
        self.coordination = 0
        self._ends, self._sent_at = threading.Event(), 0.0
        self._wants_floor, self._adopts = False, True
        self._behave()
        network.subscribe(f"{prefix}/robots/{robot_id}/report", self._take)
        network.subscribe(f"{prefix}/robots/{robot_id}/state", self._take_state)
        network.show_alive(f"{prefix}/mediator/alive")
        self._thread = threading.Thread(target=self._tick, daemon=True)
        self._thread.start()

    def _behave(self) -> None:
        """Behaves as a mediator does; checks change it."""
        self.speaks = self.echoes = self.registers = True
        # Areas whose arrays are not emptied after their last flag.
        self.full: set[str] = set()
        self.echo_behind_s = 0.0
        self.grants: Callable[[str], bool] = lambda area: True
        self.revocations: dict[str, Claim] = {}
        self.control: Any = None
        self.take_up: Any = None

    def close(self) -> None:
        """It speaks no more."""
        self._ends.set()
        self._thread.join()

    # ------------------------------------------------------------ around a check

    def provide(self, needs: Sequence[str]) -> None:
        """Skips the check where something is missing that it takes."""
        if "--start" in needs and self.program is None:
            raise Skipped("it restarts the robot: give --start 'COMMAND'")

    def prepare(self, _: bool) -> None:
        """A mediator that has just started on the same journal, and the robot registered with it."""
        if self.program is not None and (self.boot_epoch == 0 or self.program.ended()):
            self.start_robot()
        self.start_mediator()
        patience = self.patience_s if self.boot_epoch == 0 else page.SILENT_S + self.soon_s
        if self.wait(patience, self.counts) is None and self.said:
            # Whom it follows now must be silent for a second.
            self.speaks = False
            time.sleep(page.SILENT_S + 2 * page.LEVEL_S)
            self.start_mediator()
            if self.wait(self.patience_s, self.counts) is None:
                raise Failed("a robot that repeats the session and the epoch that it is offered", self.found())
        if not self.said:
            words = self.program.last_words() if self.program is not None else ""
            raise Mute(f"the robot never speaks: nothing on {self.prefix}/robots/{self.robot_id}/report within {patience:.0f} s. {words}".rstrip())

    def tidy(self, outcome: str) -> None:
        """After a failure the robot starts anew."""
        with self.lock:
            self._behave()
        if outcome == "FAILED" and self.program is not None:
            self.start_robot()

    def start_robot(self) -> None:
        """Ends the robot, and starts it on an empty floor."""
        assert self.program is not None
        self.program.end()
        with self.lock:
            self.speaks = False
            self.said.clear()
            self.states.clear()
            self.boot_epoch, self.levels, self.granted, self.next_revocation = 0, {}, set(), {}
        self.program.start()

    def start_mediator(self, epochs: int = 1) -> None:
        """Restarts the mediator on its journal: a larger epoch, another instance."""
        with self.lock:
            self.epoch, self.instance = self.epoch + epochs, random.getrandbits(64) | 1
            self.sequence = self.robot_sequence = 0
            self.said = self.said[-1:]
            self._adopts = self.speaks = True

    # ------------------------------------------------------------ reports in

    def _take(self, _: str, data: bytes) -> None:
        report: Any = wire.decode(wire.RobotReport, data)
        with self.lock:
            self.longest = max(self.longest, len(data))
            if report is None:
                return
            self.said.append(Said(time.monotonic(), report))
            for entry in report.revocations:
                run = entry.level.run + (entry.level.progress == 2)
                self.next_revocation[entry.area] = max(run, self.next_revocation.get(entry.area, 0))
            if self.speaks:
                self.react(self.said[-1])
            self.lock.notify_all()

    def _take_state(self, _: str, data: bytes) -> None:
        with self.lock:
            self.states.append((time.monotonic(), wire.decode(wire.RobotState, data)))
            self.lock.notify_all()

    def react(self, said: Said) -> None:
        """Takes in a report, and answers what is new."""
        report, news = said.report, False
        if report.boot_epoch != self.boot_epoch:
            self.boot_epoch, self.session, self.robot_sequence = report.boot_epoch, self.session + 1, 0
            news = True
        if not self.floor:
            self.learn_floor(report)
        if self.counts(said):
            if self.echoes:
                late = [old.report.sequence for old in self.said if old.at <= said.at - self.echo_behind_s and self.counts(old)]
                self.robot_sequence = max([self.robot_sequence, *late])
            news |= self._merge(report)
            self._adopts = False
        else:
            news = True
        if news:
            self.send()

    def learn_floor(self, report: Any) -> None:
        """Takes the robot's floor, or one of the kit's for a robot that has none."""
        if report.floor and floor_hash(report.floor) == report.floor_hash:
            self.floor, self._wants_floor = list(report.floor), False
        elif report.floor_hash == HASH_OF_NOTHING:
            self.floor, self._wants_floor = row(), False
        else:
            # Registered elsewhere: it lists its areas again when it is refused.
            self._wants_floor = True

    def _merge(self, report: Any) -> bool:
        before = dict(self.levels)
        for entry in report.access:
            own, theirs = self.levels.get(entry.area, Claim()), claim_of(entry)
            later = (theirs.run, theirs.progress) > (own.run, own.progress)
            if later and (self._adopts or theirs.run == own.run):
                own = theirs
            if self._adopts:
                self.fences[entry.area] = max(self.fences.get(entry.area, 0), theirs.fence)
            if (own.path, own.progress) in ((0, 4), (1, 3)) and entry.area not in self.full:
                own = Claim(own.run + 1)
            self.levels[entry.area] = own
        self.grant()
        return before != self.levels

    def grant(self) -> None:
        """Grants what is asked for and may be granted."""
        for area, own in self.levels.items():
            if own.progress == 1 and own.path == 0 and self.grants(area):
                self.fences[area] = self.fences.get(area, 0) + 1
                self.levels[area] = Claim(own.run, 0, 2, self.fences[area])
        self.granted = {area for area, own in self.levels.items() if own.held}

    def counts(self, said: Said) -> bool:
        """Whether a report is of this session and this start of the mediator."""
        report = said.report
        return (report.session, report.mediator_epoch, report.mediator_instance) == (self.session, self.epoch, self.instance)

    # ------------------------------------------------------------ messages out

    def message(self, **changed: Any) -> Any:
        """The next message, with some fields otherwise."""
        message = wire.MediatorReport(
            version=wire.Version(major=page.VERSION[0], minor=page.VERSION[1]), mediator_epoch=self.epoch, sequence=self.sequence + 1, robot_id=self.robot_id,
            boot_epoch=self.boot_epoch, session=self.session, role="guest", instance=self.instance, journal=self.journal,
            robot_sequence=self.robot_sequence, floor_hash=floor_hash(self.floor))
        newest = self.said[-1].report if self.said else None
        if newest is not None and newest.floor_hash != message.floor_hash:
            message.floor.extend(self.floor)
            message.session, message.refusal = 0, "another floor"
        elif self._wants_floor or not self.registers:
            message.session, message.refusal = 0, "not now"
        if message.session:
            for claims, entries in ((self.levels, message.access), (self.revocations, message.revocations)):
                for name, claim in claims.items():
                    entry = entries.add(area=name, fence=claim.fence)
                    entry.level.run, entry.level.path, entry.level.progress = claim.run, claim.path, claim.progress
            if self.control is not None:
                message.control.CopyFrom(self.control)
            if self.take_up is not None and newest is not None and not (newest.located and newest.session):
                message.take_up.CopyFrom(self.take_up)
        for name, value in changed.items():
            if isinstance(value, (int, str)):
                setattr(message, name, value)
            else:
                message.ClearField(name)
                getattr(message, name).MergeFrom(value)
        return message

    def send(self) -> None:
        """Sends the mediator's next message."""
        with self.lock:
            message = self.message()
            self.sequence += 1
            self._sent_at = time.monotonic()
            self.put(message)

    def put(self, message: Any, tail: bytes = b"") -> None:
        """Sends any message, with these bytes behind it."""
        self.network.put(f"{self.prefix}/mediator/to/{self.robot_id}", message.SerializeToString() + tail)

    def _tick(self) -> None:
        while not self._ends.wait(0.02):
            with self.lock:
                if self.speaks and self.boot_epoch and time.monotonic() >= self._sent_at + page.LEVEL_S * 0.8:
                    self.send()

    # ------------------------------------------------------------ judging

    def wait(self, seconds: float, until: Callable[[Said], bool]) -> Said | None:
        """The first report of which this is true, the newest and later ones; None when time is over."""
        end = time.monotonic() + seconds
        with self.lock:
            last = self.said[-1] if self.said else None
            if last is not None and until(last):
                return last
            while (left := end - time.monotonic()) > 0:
                self.lock.wait(left)
                new = self.said[next((at + 1 for at, said in enumerate(self.said) if said is last), 0):]
                for said in new:
                    if until(said):
                        return said
                last = self.said[-1] if self.said else None
        return None

    def expect(self, seconds: float, until: Callable[[Said], bool], expected: str) -> Said:
        """The first report of which this is true; a failure when there is none in time."""
        said = self.wait(seconds, until)
        if said is None:
            raise Failed(f"{expected}, within {seconds:.1f} s", self.found())
        return said

    def never(self, seconds: float, until: Callable[[Said], bool], expected: str, since: int | None = None) -> None:
        """A failure when this is true of a report in that time, or from number `since` on, or when none comes at all."""
        begin = self.said[-1] if self.said else None
        earlier = [] if since is None else self.said[since:]
        if any(until(said) for said in earlier) or self.wait(seconds, until) is not None:
            raise Failed(f"{expected}, for {seconds:.1f} s", self.found())
        if not self.said or self.said[-1] is begin:
            raise Failed("reports all the while", f"none in {seconds:.1f} s")

    def stands_in(self) -> set[str]:
        """Areas that the robot stands in, by its newest report."""
        with self.lock:
            return set(self.said[-1].report.stands_in) if self.said else set()

    def ahead(self) -> str:
        """Lets the robot drive up to a border: an area that it asks for, does not stand in, and is not granted. It has no other grant
        ahead."""
        self.grants = lambda area: area in self.stands_in()
        with self.lock:
            self.grant()
            self.send()

        def waits(said: Said) -> bool:
            inside = set(said.report.stands_in)
            ahead = [area for area in self.granted if area not in inside]
            return self.counts(said) and not ahead and any(self.asks(said, area) for area in self.levels)

        said = self.expect(self.patience_s, waits, "a request for an area that the robot does not stand in, since it drives")
        return next(area for area in self.levels if self.asks(said, area))

    def asks(self, said: Said, area: str) -> bool:
        """Whether the robot waits for an area that it does not stand in."""
        claim = said.access(area)
        return claim is not None and (claim.path, claim.progress) == (0, 1) and area not in said.report.stands_in

    def stands_still(self) -> None:
        """Waits until the robot does not move any more: what it can no longer stop before is then behind it."""
        moved, pose = time.monotonic(), self.said[-1].report.pose

        def rests(said: Said) -> bool:
            nonlocal moved, pose
            now = said.report.pose
            if abs(now.x_m - pose.x_m) + abs(now.y_m - pose.y_m) > 0.03:
                moved, pose = said.at, now
            return said.at > moved + 1.0

        self.expect(self.patience_s, rests, "a robot that stands before the border of an area that it is not granted")

    def let_into(self, area: str) -> None:
        """Grants this area too, now and later."""
        with self.lock:
            before = self.grants
            self.grants = lambda name: name == area or before(name)
            self.grant()
            self.send()

    def found(self) -> str:
        """The newest report, as a failure shows it."""
        if not self.said:
            return "no report"
        report = self.said[-1].report
        levels = ", ".join(f"{entry.area} {entry.level.run}/{entry.level.path}/{entry.level.progress} fence {entry.fence}"
                           for entry in report.access)
        answers = ", ".join(f"{entry.area} {entry.level.run}/{entry.level.path}/{entry.level.progress}" for entry in report.revocations)
        control = f", control {report.control.coordination} at {report.control.level.progress}" if report.HasField("control") else ""
        return (f"sequence {report.sequence}, epoch {report.mediator_epoch}, session {report.session}, mediator_sequence "
                f"{report.mediator_sequence}, stands in {list(report.stands_in)}, located {report.located}, levels [{levels}], answers "
                f"[{answers}]{control}, at ({report.pose.x_m:.2f}, {report.pose.y_m:.2f})")
