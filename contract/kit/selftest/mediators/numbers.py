"""Mediators whose numbers, rates or sizes are wrong."""

from __future__ import annotations

import random
import time
from typing import Any

from ... import wire
from .relay import Relay


class SequenceByTwo(Relay):
    """Its numbers grow by two."""

    def down(self, message: Any) -> Any:
        message.sequence *= 2
        return message

    def up(self, report: Any) -> Any:
        report.mediator_sequence //= 2
        return report


class SequenceRepeats(Relay):
    """It uses each number twice."""

    def down(self, message: Any) -> Any:
        message.sequence = (message.sequence + 1) // 2
        return message


class SequenceFromHundred(Relay):
    """Its numbers begin with 101."""

    def down(self, message: Any) -> Any:
        message.sequence += 100
        return message

    def up(self, report: Any) -> Any:
        report.mediator_sequence -= min(100, report.mediator_sequence)
        return report


class EpochFalls(Relay):
    """Its epoch falls with each start."""

    @property
    def more(self) -> int:
        """Above what it is."""
        return 10**6 - 1000 * self.start

    def down(self, message: Any) -> Any:
        message.mediator_epoch += self.more
        return message

    def up(self, report: Any) -> Any:
        # The larger one of the start before would give it away.
        said = self.heard.get(report.robot_id)
        report.mediator_epoch = min(max(0, report.mediator_epoch - self.more), said.mediator_epoch if said is not None else 0)
        return report


class InstanceChanges(Relay):
    """It draws an instance for each message."""

    def down(self, message: Any) -> Any:
        message.instance = random.getrandbits(64) | 1
        return message

    def up(self, report: Any) -> Any:
        said = self.heard.get(report.robot_id)
        report.mediator_instance = said.instance if said is not None and report.mediator_instance else 0
        return report


class JournalChanges(Relay):
    """Its journal has another number after each start."""

    def down(self, message: Any) -> Any:
        message.journal ^= self.start
        return message

    def up(self, report: Any) -> Any:
        report.mediator_journal ^= self.start if report.mediator_journal else 0
        return report


class EchoFrozen(Relay):
    """It goes on echoing the first report that counted."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.first: dict[int, int] = {}

    def down(self, message: Any) -> Any:
        if message.robot_sequence:
            message.robot_sequence = self.first.setdefault(message.boot_epoch, message.robot_sequence)
        return message


class EchoAhead(Relay):
    """It echoes reports that were not sent."""

    def down(self, message: Any) -> Any:
        message.robot_sequence += 100 if message.robot_sequence else 0
        return message


class EchoesAll(Relay):
    """It echoes reports that do not count."""

    def down(self, message: Any) -> Any:
        said = self.said.get(message.robot_id)
        if message.robot_sequence and said is not None and said.boot_epoch == message.boot_epoch:
            message.robot_sequence = said.sequence
        return message


class AcknowledgesAtOnce(Relay):
    """It acknowledges what it does not believe yet."""

    def down(self, message: Any) -> Any:
        said = self.said.get(message.robot_id)
        if said is not None and said.session and said.session == message.session:
            message.robot_sequence = message.robot_sequence or said.sequence
        return message


class Slow(Relay):
    """It passes every third message on, with numbers that grow by one."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.count: dict[str, int] = {}

    def down(self, message: Any) -> Any:
        count = self.count[message.robot_id] = self.count.get(message.robot_id, -1) + 1
        message.sequence = count // 3 + 1
        return message if count % 3 == 0 else None


class TooLong(Relay):
    """Some of its messages are longer than 1 MiB."""

    at = 0.0

    def down(self, message: Any) -> Any:
        if time.monotonic() < self.at + 0.5:
            return message
        self.at = time.monotonic()
        self.send_down(message.robot_id, message, wire.unknown_field(999, wire.LONGEST_MESSAGE))
        return None


class KeepsEpoch(Relay):
    """It does not hear of a larger epoch in its name."""

    def up(self, report: Any) -> Any:
        said = self.heard.get(report.robot_id)
        return report if said is None or report.mediator_epoch <= said.mediator_epoch else None


class RunsFromRobots(Relay):
    """It goes on with whatever run a robot names."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.most: dict[tuple[str, str], int] = {}

    def up(self, report: Any) -> Any:
        for one in report.access:
            key, real = (report.robot_id, one.area), self.real(report.robot_id, one.area).level.run
            self.most[key] = max(self.most.get(key, 0), one.level.run)
            if one.level.run == self.most[key]:
                one.level.run = real
        return report

    def down(self, message: Any) -> Any:
        for one in message.access:
            one.level.run = max(one.level.run, self.most.get((message.robot_id, one.area), 0))
        return message


class DeafAfterNoise(Relay):
    """Bytes that are no report make it deaf to that robot for a while."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.until: dict[str, float] = {}

    def noise(self, robot_id: str, data: bytes) -> bytes | None:
        self.until[robot_id] = time.monotonic() + 5.0
        return None

    def up(self, report: Any) -> Any:
        return report if time.monotonic() > self.until.get(report.robot_id, 0.0) else None


class AnyLength(Relay):
    """It takes in reports of any length."""

    def noise(self, robot_id: str, data: bytes) -> bytes | None:
        if len(data) <= wire.LONGEST_MESSAGE:
            return data
        report = wire.RobotReport.FromString(data)
        report.DiscardUnknownFields()
        return bytes(report.SerializeToString())


class FallsBehind(Relay):
    """Each report costs it 20 ms, whosever it is."""

    def up(self, report: Any) -> Any:
        time.sleep(0.02)
        return report

    def noise(self, robot_id: str, data: bytes) -> bytes | None:
        time.sleep(0.02)
        return data
