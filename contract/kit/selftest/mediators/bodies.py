"""Mediators that are wrong about processes that do not speak for their robot."""

from __future__ import annotations

import time
from typing import Any

from ... import page, wire
from .relay import Relay


class Bodies(Relay):
    """Knows which processes do not speak for their robots, and the newest report of each."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        # By robot, the process that speaks for it; by boot, when it was heard, and its newest report.
        self.speaks: dict[str, int] = {}
        self.bodies: dict[int, tuple[float, Any]] = {}

    def down(self, message: Any) -> Any:
        if message.session:
            self.speaks[message.robot_id] = message.boot_epoch
            self.bodies.pop(message.boot_epoch, None)
        return message

    def up(self, report: Any) -> Any:
        if self.speaks.get(report.robot_id, report.boot_epoch) != report.boot_epoch:
            self.bodies[report.boot_epoch] = (time.monotonic(), report)
        return report

    def forget(self, said: Any) -> None:
        """It is nowhere any more, for all that the mediator knows."""
        last = wire.RobotReport()
        last.CopyFrom(said)
        last.sequence += 1
        del last.stands_in[:]
        self.send_up(last.robot_id, last.SerializeToString())


class IgnoresBodies(Bodies):
    """It does not ask where a process is that does not speak for its robot."""

    def up(self, report: Any) -> Any:
        report = super().up(report)
        if report.boot_epoch in self.bodies:
            del report.stands_in[:]
        return report


class ForgetsSilentBodies(Bodies):
    """It takes the body of such a process to be gone when that has been silent for 1 s."""

    def tick(self) -> None:
        for boot, (at, said) in list(self.bodies.items()):
            if time.monotonic() > at + page.SILENT_S:
                del self.bodies[boot]
                self.forget(said)


class ForgetsBodiesAtStart(Bodies):
    """After a start it does not know where such processes were that are silent."""

    told = False

    def up(self, report: Any) -> Any:
        report = super().up(report)
        if report.boot_epoch in self.bodies:
            (self.folder / f"body-{report.boot_epoch}").write_bytes(report.SerializeToString())
        return report

    def tick(self) -> None:
        if self.start > 1 and not self.told:
            self.told = True
            for file in self.folder.glob("body-*"):
                said: Any = wire.decode(wire.RobotReport, file.read_bytes())
                self.forget(said)
