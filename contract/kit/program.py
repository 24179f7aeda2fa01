"""The program under test, where the kit is given a command line to start it by."""

from __future__ import annotations

import os
import shlex
import signal
import subprocess
import tempfile
import time
from pathlib import Path


# How long a program may take to end by itself.
ENDS_S = 3.0


class Program:
    """Starts, kills and restarts one process with its children, and keeps what it writes.

    In the command line `{endpoint}`, `{prefix}` and `{folder}` stand for the endpoint, the key prefix, and a folder of its own that
    outlives a restart. A start `anew` has an empty folder.
    """

    def __init__(self, command: str, **values: str) -> None:
        self.command, self.values = command, values
        self._process: subprocess.Popen[bytes] | None = None
        self._folders: list[tempfile.TemporaryDirectory[str]] = []
        # When it was started last, by `time.monotonic`.
        self.started_at = 0.0

    @property
    def folder(self) -> Path:
        """The folder of the present start."""
        return Path(self._folders[-1].name)

    def start(self, anew: bool = False) -> None:
        """Starts it; one that runs is killed before."""
        self.kill()
        if anew or not self._folders:
            self._folders.append(tempfile.TemporaryDirectory(prefix="kit-"))
        command = self.command
        for name, value in {**self.values, "folder": str(self.folder)}.items():
            command = command.replace("{" + name + "}", shlex.quote(value))
        self.started_at = time.monotonic()
        with open(self.folder / "output.log", "ab") as log:
            self._process = subprocess.Popen(["sh", "-c", command], stdout=log, stderr=log, stdin=subprocess.DEVNULL,
                                             start_new_session=True)

    def signal(self, number: int) -> None:
        """Sends a signal to the process and its children."""
        if self._process is not None and self._process.poll() is None:
            os.killpg(self._process.pid, number)

    def kill(self) -> None:
        """Kills it, as a power loss would."""
        if self._process is None:
            return
        try:
            # Children may live although the shell has ended.
            os.killpg(self._process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        self._process.wait()
        self._process = None

    def end(self) -> None:
        """Ends it as its operator would, so that it leaves nothing behind; kills it when that takes long."""
        self.signal(signal.SIGTERM)
        until = time.monotonic() + ENDS_S
        while self._lives() and time.monotonic() < until:
            time.sleep(0.02)
        self.kill()

    def _lives(self) -> bool:
        """Whether any of its processes does; its shell may have ended before the others."""
        if self._process is None:
            return False
        self._process.poll()
        try:
            os.killpg(self._process.pid, 0)
        except ProcessLookupError:
            return False
        return True

    def ended(self) -> bool:
        """Whether it has ended by itself."""
        return self._process is not None and self._process.poll() is not None

    def last_words(self) -> str:
        """The end of what it wrote."""
        try:
            lines = (self.folder / "output.log").read_text(errors="replace").splitlines()
        except (OSError, IndexError):
            return ""
        return " / ".join(line.strip() for line in lines[-3:])

    def close(self) -> None:
        """Ends it and removes its folders."""
        self.end()
        for folder in self._folders:
            folder.cleanup()
        self._folders.clear()
