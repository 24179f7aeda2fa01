"""Stands between the kit's robots and a mediator, and passes everything on as it is. Wrong mediators are this with one mistake.

It starts the mediator by the command line in the environment variable KIT_MEDIATOR, and ends when that does.
"""

from __future__ import annotations

import os
import shlex
import subprocess
import threading
import time
from pathlib import Path
from typing import Any

from ... import wire
from ...network import Network, free_endpoint

VARIABLE = "KIT_MEDIATOR"


class Relay:
    """The right one. The wrong ones change reports on their way `up`, and messages on their way `down`, in place; None drops them."""

    def __init__(self, prefix: str, folder: Path) -> None:
        self.prefix, self.folder = prefix, folder
        self.lock = threading.RLock()
        self.inner: Any = None
        self.outer: Any = None
        # Which start on this folder, from 1 on.
        starts = folder / "starts"
        self.start = int(starts.read_text(encoding="ascii")) + 1 if starts.exists() else 1
        starts.write_text(str(self.start), encoding="ascii")
        # By robot: the newest report as it was sent, the newest message as the mediator meant it.
        self.said: dict[str, Any] = {}
        self.heard: dict[str, Any] = {}

    def up(self, report: Any) -> Any:
        """A report on its way to the mediator."""
        return report

    def down(self, message: Any) -> Any:
        """A message on its way to a robot."""
        return message

    def noise(self, robot_id: str, data: bytes) -> bytes | None:
        """Bytes on their way to the mediator that are no report."""
        return data

    def tick(self) -> None:
        """Some time has passed."""

    def real(self, robot_id: str, area: str) -> Any:
        """What the mediator has said last of an area; an empty level where it has said nothing."""
        message = self.heard.get(robot_id)
        return entry(message.access, area) or wire.AccessGrant() if message is not None else wire.AccessGrant()

    def send_up(self, robot_id: str, data: bytes) -> None:
        """Sends to the mediator, as this robot."""
        self.inner.put(f"{self.prefix}/robots/{robot_id}/report", data)

    def send_down(self, robot_id: str, message: Any, tail: bytes = b"") -> None:
        """Sends to a robot, with these bytes behind it."""
        self.outer.put(f"{self.prefix}/mediator/to/{robot_id}", message.SerializeToString() + tail)

    def take_up(self, key: str, data: bytes) -> None:
        """Passes a report on."""
        robot_id = key.split("/")[-2]
        report: Any = wire.decode(wire.RobotReport, data)
        with self.lock:
            if report is None:
                passed = self.noise(robot_id, data)
                if passed is not None:
                    self.send_up(robot_id, passed)
                return
            changed = wire.RobotReport()
            changed.CopyFrom(report)
            changed = self.up(changed)
            self.said[robot_id] = report
            if changed is not None:
                self.send_up(robot_id, changed.SerializeToString())

    def take_down(self, key: str, data: bytes) -> None:
        """Passes a message on."""
        message: Any = wire.decode(wire.MediatorReport, data)
        robot_id = key.rsplit("/", 1)[-1]
        with self.lock:
            changed = wire.MediatorReport()
            changed.CopyFrom(message)
            self.heard[robot_id] = message
            changed = self.down(changed)
            if changed is not None:
                self.send_down(robot_id, changed)

    def show_alive(self) -> None:
        """The mediator is there."""
        self.outer.show_alive(f"{self.prefix}/mediator/alive")

    def run(self, endpoint: str) -> None:
        """Runs until the mediator ends."""
        near, command = free_endpoint(), os.environ[VARIABLE]
        for name, value in (("endpoint", near), ("prefix", self.prefix), ("folder", str(self.folder))):
            command = command.replace("{" + name + "}", shlex.quote(value))
        program = subprocess.Popen(["sh", "-c", f"exec {command}"], stdin=subprocess.DEVNULL)
        self.inner, self.outer = Network(connect=[near]), Network(listen=[endpoint])
        self.inner.subscribe(f"{self.prefix}/mediator/to/*", self.take_down)
        while program.poll() is None and not self.inner.is_alive(f"{self.prefix}/mediator/alive"):
            time.sleep(0.05)
        # Reports count from here on: the first one after a start is another thing than those that follow.
        self.outer.subscribe(f"{self.prefix}/robots/*/report", self.take_up)
        self.show_alive()
        while program.poll() is None:
            time.sleep(0.05)
            with self.lock:
                self.tick()


def entry(entries: Any, area: str) -> Any:
    """The level of an area, or None."""
    return next((one for one in entries if one.area == area), None)


def held(one: Any) -> bool:
    """Granted, and neither released nor returned."""
    return one.level.path == 0 and one.level.progress in (2, 3)


def set_level(one: Any, run: int, path: int, progress: int, fence: int) -> None:
    """Another level in place of this."""
    one.level.run, one.level.path, one.level.progress, one.fence = run, path, progress, fence
