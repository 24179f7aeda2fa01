"""Checks in shares, each with a program of its own, at the same time: most of them wait most of the time."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Sequence

from .checks import Check, Result, close

FOLDER = Path(__file__).resolve().parent
CLOSING = re.compile(r"\d+ ok, \d+ failed, ")


def run_shares(words: Sequence[str], checks: Sequence[Check], jobs: int, json_file: str | None) -> int:
    """Runs this command line in so many processes, each with some of the checks. Returns the exit code of all."""
    begin, shares = time.monotonic(), [share for at in range(jobs) if (share := checks[at::jobs])]
    processes: list[subprocess.Popen[str]] = []
    readers: list[threading.Thread] = []
    with tempfile.TemporaryDirectory(prefix="kit-") as folder:
        files = [Path(folder) / str(at) for at in range(len(shares))]
        try:
            for share, file in zip(shares, files):
                only = ["--jobs", "1", "--only", ",".join(check.name for check in share), "--json", str(file)]
                processes.append(subprocess.Popen([sys.executable, str(FOLDER), *words, *only], stdin=subprocess.DEVNULL,
                                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True))
                readers.append(threading.Thread(target=pass_on, args=(processes[-1],), daemon=True))
                readers[-1].start()
            for process in processes:
                process.wait()
        finally:
            # Also when it is interrupted: each ends the programs that it has started, and says what it knows.
            for process in processes:
                process.terminate()
            for process in processes:
                process.wait()
            for reader in readers:
                reader.join()
            results = [Result(**result) for file in files if file.exists() for result in json.loads(file.read_text(encoding="utf-8"))]
            code = close(results, len(checks), begin, json_file)
    return max([code, *(process.returncode for process in processes)])


def pass_on(process: subprocess.Popen[str]) -> None:
    """Prints what a process says of each check, undivided by what others say, and leaves out how it closes."""
    assert process.stdout is not None
    said = ""
    for line in process.stdout:
        if not line.startswith(" "):
            print(said, end="", flush=True)
            said = ""
        said += "" if CLOSING.match(line) else line
    print(said, end="", flush=True)
