"""Mediators that are wrong about other mediators, and about coordinations."""

from __future__ import annotations

import time
from typing import Any

from ... import wire
from ...played_robot import next_flag
from .relay import Relay, entry, set_level


class NeverStandsBy(Relay):
    """It does not hear that robots follow another mediator."""

    def up(self, report: Any) -> Any:
        said = self.heard.get(report.robot_id)
        follows = said is None or report.mediator_instance in (0, said.instance)
        return report if follows or not report.mediator_heard else None


class GrantsStandingBy(Relay):
    """It says that it stands by, and grants."""

    def down(self, message: Any) -> Any:
        said = self.said.get(message.robot_id)
        for last in said.access if said is not None and message.stands_by else ():
            if last.level.progress == 1:
                set_level(entry(message.access, last.area) or message.access.add(area=last.area), last.level.run, 0, 2, 10**6)
        return message


class OtherInstances(Relay):
    """It takes reports to another mediator for its own."""

    def up(self, report: Any) -> Any:
        said = self.heard.get(report.robot_id)
        if said is not None and report.mediator_instance:
            report.mediator_instance, report.mediator_journal = said.instance, said.journal
        return report


class IgnoresOthers(Relay):
    """It does not hear of robots that have followed another mediator."""

    def up(self, report: Any) -> Any:
        said = self.heard.get(report.robot_id)
        return report if said is None or report.mediator_instance in (0, said.instance) else None


class LevelsTooEarly(Relay):
    """It sends levels under a larger epoch before the robot has reported under it."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.last: dict[str, list[Any]] = {}

    def down(self, message: Any) -> Any:
        said = self.said[message.robot_id]
        if message.access:
            self.last[message.robot_id] = list(message.access)
        elif 0 < said.mediator_epoch < message.mediator_epoch:
            message.access.extend(self.last.get(message.robot_id) or [wire.AccessGrant(area="a")])
        return message


class TakesAnybody(Relay):
    """It takes robots into coordinations that know none."""

    def up(self, report: Any) -> Any:
        report.without_control = False
        return report


class Controls(Relay):
    """Knows each robot's coordination as the mediator means it."""

    def control(self, robot_id: str) -> Any:
        """The coordination, or None."""
        said = self.heard.get(robot_id)
        return said.control if said is not None and said.HasField("control") else None


class SetsRobotsFlags(Controls):
    """It sets the robot's next flag itself."""

    def down(self, message: Any) -> Any:
        if message.HasField("control"):
            following = next_flag(message.control, message.control.level.path, message.control.level.progress)
            message.control.level.progress += following is not None and not following.by_mediator
        return message


class SkipsFlags(Controls):
    """It sets its next flag before the robot has answered the last one."""

    def up(self, report: Any) -> Any:
        control = self.control(report.robot_id)
        if control is not None and control.level.progress == 3:
            report.control.coordination = control.coordination
            report.control.level.path, report.control.level.progress = control.level.path, 4
        return report


class BelievesFlags(Controls):
    """It believes a robot that claims the mediator's flags."""

    def up(self, report: Any) -> Any:
        control = self.control(report.robot_id)
        if control is not None and report.control.level.progress > control.level.progress + 1:
            report.control.level.progress = control.level.progress + 1
        return report


class AnyCoordination(Controls):
    """It does not look at the number of the coordination that a robot answers."""

    def up(self, report: Any) -> Any:
        control = self.control(report.robot_id)
        if control is not None and report.HasField("control"):
            report.control.coordination = control.coordination
        return report


class NumberStays(AnyCoordination):
    """All its coordinations have one number."""

    def down(self, message: Any) -> Any:
        if message.HasField("control"):
            message.control.coordination = 5
        return message


class NoRelease(Controls):
    """Its flags do not end with release and released."""

    def down(self, message: Any) -> Any:
        for flag in message.control.flags if message.HasField("control") else ():
            flag.name = {"release": "free", "released": "freed"}.get(flag.name, flag.name)
        return message


class NeverFree(Controls):
    """It never says that a robot is free again."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.last: dict[str, Any] = {}

    def down(self, message: Any) -> Any:
        if message.HasField("control"):
            self.last[message.robot_id] = wire.Control()
            self.last[message.robot_id].CopyFrom(message.control)
        elif message.robot_id in self.last:
            message.control.CopyFrom(self.last[message.robot_id])
        return message


class EndsEarly(Controls):
    """It does not wait for 5 s for the answer to acquire."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.since: dict[int, float] = {}

    def down(self, message: Any) -> Any:
        if message.HasField("control") and message.control.level.progress == 1:
            if time.monotonic() > self.since.setdefault(message.control.coordination, time.monotonic()) + 2.0:
                message.ClearField("control")
        return message


class ControlOnce(Controls):
    """It sends the flags of a coordination once."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.sent: set[int] = set()

    def down(self, message: Any) -> Any:
        if message.HasField("control"):
            number = message.control.coordination
            if number in self.sent:
                message.control.ClearField("flags")
                message.control.ClearField("paths")
            self.sent.add(number)
        return message
