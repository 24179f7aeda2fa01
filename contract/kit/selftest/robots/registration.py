"""Robots that register, or are refused, wrongly."""

from __future__ import annotations

import math
from typing import Any

from ... import page, wire
from ...robot import Robot


class ForgetsSession(Robot):
    """It leaves the session out of some of its reports."""

    def report(self, now: float) -> Any:
        report = super().report(now)
        if self.sequence % 5 == 0:
            report.session = 0
        return report


class IgnoresIdentityTaken(Robot):
    """It keeps its areas when another process speaks for it."""

    def forget(self) -> None:
        if self.session != 0:
            super().forget()


class TakesOtherFloors(Robot):
    """It follows a mediator that knows another floor."""

    def same_floor(self, message: Any) -> bool:
        super().same_floor(message)
        return True


class RegistersAnyVersion(Robot):
    """It does not look at the version."""

    def receive(self, data: bytes, now: float) -> None:
        message: Any = wire.decode(wire.MediatorReport, data)
        if message is not None:
            message.version.major = page.VERSION[0]
            super().receive(message.SerializeToString(), now)


class BelievesOtherBoots(Robot):
    """It does not look for which of its boots a message is."""

    def is_for_me(self, message: Any) -> bool:
        message.boot_epoch = self.boot_epoch
        return super().is_for_me(message)


class ConstantBoot(Robot):
    """It has the same boot epoch each time."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.boot_epoch = 42


class BelievesTakeUp(Robot):
    """It takes where it was heard last for where it is."""

    def receive(self, data: bytes, now: float) -> None:
        super().receive(data, now)
        if self.take_up is not None:
            self.body.x_m, self.body.y_m = self.take_up.pose.x_m, self.take_up.pose.y_m
            self.located, self.take_up = True, None


class KeepsInherited(Robot):
    """It goes on with the grants of the process before."""

    def learn_levels(self, message: Any, registers: bool) -> None:
        super().learn_levels(message, registers)
        for claim in self.claims.values():
            claim.inherited = False

    def set_flags(self, wanted: list[str], committed: list[str]) -> None:
        super().set_flags(wanted + list(self.claims), committed)


class KeepsFirstSession(Robot):
    """It takes no other session from a mediator that has given it one."""

    def is_for_me(self, message: Any) -> bool:
        if self.session and message.session and message.instance == self.instance:
            message.session = self.session
        return super().is_for_me(message)


class EchoesFirst(Robot):
    """It goes on echoing the first message."""

    def report(self, now: float) -> Any:
        report = super().report(now)
        report.mediator_sequence = min(report.mediator_sequence, 1)
        return report


class KeepsSession(Robot):
    """It goes on with its session when it is refused."""

    def receive(self, data: bytes, now: float) -> None:
        before = self.session
        super().receive(data, now)
        if self.session == 0 and self.refusal:
            self.session = before


class EntersWhenRefused(Robot):
    """It enters what it was granted when it has been refused for long."""

    registered_at = math.inf

    def receive(self, data: bytes, now: float) -> None:
        super().receive(data, now)
        if self.session:
            self.registered_at = now

    def has_lease(self, now: float) -> bool:
        return super().has_lease(now) or now > self.registered_at + page.ENTERS_NO_MORE_S + 0.5


class BelievesOtherNames(Robot):
    """It does not look for which robot a message is."""

    def is_for_me(self, message: Any) -> bool:
        message.robot_id = self.robot_id
        return super().is_for_me(message)


class TakesFloorLate(Robot):
    """It looks at the floor that it is sent after 3 s alone."""

    since = 0.0

    def same_floor(self, message: Any) -> bool:
        self.since = self.since or self.heard_at
        if self.heard_at < self.since + 3.0:
            return bool(message.floor_hash == self.floor_hash)
        return super().same_floor(message)
