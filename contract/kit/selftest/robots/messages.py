"""Robots whose reports are wrong, or that take messages in wrongly."""

from __future__ import annotations

import math
import time
from typing import Any

from ... import wire
from ...body import centre
from ...identity import Identity
from ...link import Link
from ...network import Network
from ...robot import Robot


class CountsByTwo(Robot):
    """Its numbers grow by two."""

    def report(self, now: float) -> Any:
        self.sequence += 1
        return super().report(now)


class LooksLate(Robot):
    """It names an area when its middle is inside."""

    def step(self, now: float, seconds: float) -> None:
        super().step(now, seconds)
        x, y = self.body.x_m, self.body.y_m
        self.stands_in = [area.id for area in self.floor if area.id in self.stands_in and math.dist((x, y), centre(area)) < 0.5]


class BelievesOldMessages(Robot):
    """It takes in messages in the order in which they come."""

    def is_for_me(self, message: Any) -> bool:
        return message.robot_id == self.robot_id and message.boot_epoch == self.boot_epoch

    def receive(self, data: bytes, now: float) -> None:
        message: Any = wire.decode(wire.MediatorReport, data)
        super().receive(data, now)
        for entry in message.access if message is not None else ():
            # It overwrites what it knows by what it hears.
            if entry.area in self.claims and entry.level.progress == 2:
                self.claims[entry.area].progress, self.claims[entry.area].fence = 2, entry.fence


class SeldomReports(Link):
    """Passes on two reports a second."""

    name, at = "report", 0.0

    def put(self, name: str, message: Any) -> None:
        if name == self.name:
            if time.monotonic() < self.at + 0.5:
                return
            self.at = time.monotonic()
        super().put(name, message)


class ReportsSeldom(Robot):
    """It reports twice a second."""

    link = SeldomReports


class SeldomStates(SeldomReports):
    """Passes on two states a second."""

    name = "state"


class ShowsSeldom(Robot):
    """It tells everybody its state twice a second."""

    link = SeldomStates


class LinkWithoutToken(Link):
    """Declares no token."""

    def _open(self, identity: Identity | None) -> Network:
        network = Network(connect=[self._endpoint], identity=identity)
        network.subscribe(self._mine, lambda _, data: self._take(data))
        return network


class NoToken(Robot):
    """It declares no liveliness token."""

    link = LinkWithoutToken


class SaysOtherVersion(Robot):
    """It says another version than it speaks."""

    def report(self, now: float) -> Any:
        report = super().report(now)
        report.version.major -= 1
        return report


class ForgetsFloorHash(Robot):
    """It says the floor's hash now and then."""

    def report(self, now: float) -> Any:
        report = super().report(now)
        if self.session and self.sequence % 5:
            report.floor_hash = 0
        return report


class TooLong(Robot):
    """Some of its reports are longer than 1 MiB."""

    def report(self, now: float) -> Any:
        report = super().report(now)
        if self.sequence % 5 == 0:
            report.fsm_state = "x" * wire.LONGEST_MESSAGE
        return report


class DropsUnknownFields(Robot):
    """It ignores messages with fields that it does not know."""

    def receive(self, data: bytes, now: float) -> None:
        message: Any = wire.decode(wire.MediatorReport, data)
        if message is not None:
            message.DiscardUnknownFields()
            if message.ByteSize() == len(data):
                super().receive(data, now)


class DeafAfterNoise(Robot):
    """Bytes that are no message make it deaf for a while."""

    deaf_until = 0.0

    def receive(self, data: bytes, now: float) -> None:
        if wire.decode(wire.MediatorReport, data) is None:
            self.deaf_until = now + 5.0
        if now > self.deaf_until:
            super().receive(data, now)


class AnyLength(Robot):
    """It takes in messages of any length."""

    def receive(self, data: bytes, now: float) -> None:
        if len(data) > wire.LONGEST_MESSAGE:
            message = wire.MediatorReport.FromString(data)
            message.DiscardUnknownFields()
            data = message.SerializeToString()
        super().receive(data, now)


class FallsBehind(Robot):
    """Each message costs it 20 ms, whatever it is."""

    def receive(self, data: bytes, now: float) -> None:
        time.sleep(0.02)
        super().receive(data, now)


class LooksAreasUp(Robot):
    """It ends when it hears of an area that its floor does not have."""

    def step(self, now: float, seconds: float) -> None:
        known = {area.id: area for area in self.floor}
        for name in self.claims:
            known[name]
        super().step(now, seconds)
