"""Tests the kit itself: its sentences are those of PROTOCOL.md, the example robot passes, and robots that are wrong are found.

`python -m kit selftest` does all of it; `--only NAME,...` some of the wrong robots.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Sequence

from . import wire
from .floor import area, floor_hash
from .wrong_robots import WRONG

FOLDER = Path(__file__).resolve().parent.parent
ARGUMENTS = "--connect {endpoint} --prefix {prefix} --at 0.75,0 --route a,b,c,d"


def test(robot: str, only: str, folder: str) -> tuple[int, str]:
    """Runs `kit robot` against a robot of this module. Returns exit code and output."""
    command = f"exec {sys.executable} -m kit.wrong_robots {robot} {ARGUMENTS}"
    done = subprocess.run([sys.executable, "-m", "kit", "robot", "--start", command, "--only", only], cwd=FOLDER, capture_output=True,
                          text=True, timeout=1200, check=False)
    Path(folder, f"{robot}.txt").write_text(done.stdout + done.stderr, encoding="utf-8")
    return done.returncode, done.stdout + done.stderr


def judge(robot: str, folder: str) -> tuple[bool, str]:
    """Whether a wrong robot fails just the checks that it must."""
    _, checks = WRONG[robot]
    _, output = test(robot, ",".join(checks), folder)
    failed = re.findall(r"^FAILED  ([\w-]+)", output, re.MULTILINE)
    missed = [check for check in checks if check not in failed]
    return not missed, f"passes {', '.join(missed)}" if missed else f"found by {', '.join(checks)}"


def page_errors() -> list[str]:
    """What is wrong with the kit's own reading of the page: its sentences, and the bytes of its example."""
    from .command import suite_of
    errors = [error for side in ("mediator", "robot") for error in suite_of(side).errors()]
    from .page import PAGE
    text = PAGE.read_text(encoding="utf-8")
    found = re.search(r"```text\n((?:[0-9a-f]{2}[ \n])+)```", text)
    data = bytes.fromhex("".join(found.group(1).split())) if found else b""
    report = wire.RobotReport.FromString(data)
    if not data or report.SerializeToString() != data or report.robot_id != "agv":
        errors.append("the example's bytes are not read and written alike")
    if report.floor_hash != floor_hash([area("bay", 2, -0.5, 0.0, 3.0, 2.25)]):
        errors.append("the example's floor_hash is not that of the bay")
    return errors


def main(arguments: Sequence[str]) -> int:
    """Runs the test. Returns the exit code."""
    options = argparse.ArgumentParser(prog="kit selftest", description=__doc__.split("\n")[0])
    options.add_argument("--only", help="these wrong robots alone, separated by commas")
    options.add_argument("--jobs", type=int, default=2, help="how many at a time [default: 2]")
    said = options.parse_args(arguments)
    errors = page_errors()
    print(*(errors or ["ok      sentences and example of PROTOCOL.md"]), sep="\n", flush=True)
    names = said.only.split(",") if said.only else list(WRONG)
    wrong = len(errors)
    with tempfile.TemporaryDirectory(prefix="kit-") as folder, ThreadPoolExecutor(said.jobs) as pool:
        for name, (good, what) in zip(names, pool.map(lambda name: judge(name, folder), names)):
            print(f"{'ok' if good else 'FAILED':8}{name}: {WRONG[name][0].__doc__} {what}", flush=True)
            wrong += not good
        if not said.only:
            code, output = test("right", "", folder)
            wrong += code != 0
            print(f"{'ok' if code == 0 else 'FAILED':8}the example robot: {output.strip().splitlines()[-1]}")
            if code:
                print(output)
    print(f"{len(names)} wrong robots, {wrong} problems")
    return 1 if wrong else 0
