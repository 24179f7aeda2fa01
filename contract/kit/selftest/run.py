"""Tests the kit itself: its sentences are those of PROTOCOL.md, who is right passes, and who is wrong in one thing is found.

`python -m kit selftest` tests with robots; with `--mediator COMMAND` with mediators too; `--only NAME,...` with some of the wrong ones.
"""

from __future__ import annotations

import argparse
import os
import random
import re
import signal
import sys
import time
import traceback
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO, Any, Callable, Sequence

from .. import of_mediator, of_robot, wire
from ..command import main as command
from ..floor import area, floor_hash
from ..identity import EXPECTED, Identity, NoLink
from ..identity import check as check_links
from .mediators import VARIABLE
from .mediators import WRONG as WRONG_MEDIATORS
from .robots import WRONG as WRONG_ROBOTS

FOLDER = Path(__file__).resolve().parent.parent.parent
ROBOT = "exec {python} -m kit.selftest.robots {name} --connect {{endpoint}} --prefix {{prefix}} --at 0.75,0 --route a,b,c,d"
MEDIATOR = "exec {python} -m kit.selftest.mediators {name} {{endpoint}} {{prefix}} {{folder}}"
# In how many processes all checks of one side are run.
SHARES = 6
# All checks of one side, with patience.
LONGEST_S = 1800


@dataclass(frozen=True)
class Case:
    """Somebody to be tested: what is wrong, and the checks that must find it. Who is right has none, and must pass all."""

    side: str
    name: str
    about: str
    checks: tuple[str, ...] = ()

    def words(self, margin: str) -> list[str]:
        """The command line of its test, behind `kit`."""
        options = ["--areas", "a,b,c,hall", "--coordinated", "kit-1:call:bay"] if self.side == "mediator" else []
        start = (MEDIATOR if self.side == "mediator" else ROBOT).format(python=sys.executable, name=self.name)
        chosen = ["--only", ",".join(self.checks)] if self.checks else ["--jobs", str(SHARES)]
        if self.checks and self.side == "robot":
            # What a wrong one never does need not be awaited for long.
            chosen += ["--patience", "12"]
        return [self.side, *options, "--start", start, *chosen, "--margin", margin]


def cases(with_mediators: bool) -> list[Case]:
    """All of them, who is right first."""
    right = [Case("robot", "right", "The example robot.")]
    wrong = [Case("robot", name, kind.__doc__ or "", tuple(checks)) for name, (kind, checks) in WRONG_ROBOTS.items()]
    if with_mediators:
        right.insert(0, Case("mediator", "right", "The mediator behind a relay that changes nothing."))
        wrong += [Case("mediator", name, kind.__doc__ or "", tuple(checks)) for name, (kind, checks) in WRONG_MEDIATORS.items()]
    return right + wrong


class Runs:
    """The tests that run at present, each a copy of this process: nothing is imported again, and none outlives it."""

    def __init__(self, mediator: str, margin: str) -> None:
        self._margin = margin
        self._running: dict[int, tuple[Case, IO[bytes]]] = {}
        path = os.pathsep.join([str(FOLDER), *filter(None, [os.environ.get("PYTHONPATH")])])
        os.environ.update({"PYTHONPATH": path, VARIABLE: mediator})

    def __len__(self) -> int:
        return len(self._running)

    def begin(self, case: Case) -> None:
        """Begins a test."""
        output = TemporaryFile()
        sys.stdout.flush()
        test = os.fork()
        if test == 0:
            code = 1
            try:
                os.dup2(output.fileno(), 1)
                os.dup2(output.fileno(), 2)
                # Ports and prefixes are drawn by each, and it ends what it has started.
                random.seed()
                signal.signal(signal.SIGALRM, lambda number, _: sys.exit(128 + number))
                signal.alarm(LONGEST_S)
                code = command(case.words(self._margin))
            except SystemExit as end:
                code = end.code if isinstance(end.code, int) else 1
            except BaseException:
                traceback.print_exc()
            finally:
                sys.stdout.flush()
                sys.stderr.flush()
                os._exit(code)
        self._running[test] = (case, output)

    def ended(self) -> tuple[Case, bool, str]:
        """Waits until one has ended. Whether somebody right passes all, or somebody wrong fails just the checks that it must; and what to
        say of it."""
        test, status = os.wait()
        case, output = self._running.pop(test)
        output.seek(0)
        said = output.read().decode(errors="replace")
        output.close()
        if not case.checks:
            good, closing = status == 0, (said.strip().splitlines() or ["no output"])[-1]
            return case, good, closing if good else f"{closing}\n{said}"
        failed = re.findall(r"^FAILED  ([\w-]+)", said, re.MULTILINE)
        missed = [check for check in case.checks if check not in failed]
        return case, not missed, f"not found by {', '.join(missed)}:\n{said}" if missed else f"found by {', '.join(case.checks)}"

    def end(self) -> None:
        """Ends all; each ends the programs that it has started."""
        for test in self._running:
            os.kill(test, signal.SIGTERM)
        while self._running:
            self._running.pop(os.wait()[0])


def identity_errors() -> list[str]:
    """What is wrong with how files of identities are read, and which endpoints they go with."""
    block = "-----BEGIN {0}-----\nAAAA\n-----END {0}-----\n"
    blocks = [block.format(name) for name in EXPECTED]
    whole = Identity.parse("a comment\n" + "".join(blocks), "whole")
    errors = [] if [whole.key, whole.certificate, whole.authority] == blocks else ["an identity's blocks are not read as they are written"]
    lacking = ["".join(blocks[:at] + blocks[at + 1:]) for at in range(3)]
    refused: list[Callable[[], Any]] = [partial(Identity.parse, text, "a file") for text in lacking]
    for call in (*refused, partial(check_links, ["tcp/127.0.0.1:1"], whole), partial(check_links, ["tls/127.0.0.1:1"], None)):
        try:
            call()
            errors.append("an identity that lacks a block, or an endpoint that does not go with it, is not refused")
        except NoLink:
            pass
    return errors


def page_errors() -> list[str]:
    """What is wrong with the kit's own reading of the page: its sentences, and the bytes of its example."""
    suites = {"mediator": of_mediator.SUITE, "robot": of_robot.SUITE}
    errors = [error for suite in suites.values() for error in suite.errors()]
    for case in cases(True):
        known = {check.name for check in suites[case.side].checks}
        errors += [f"wrong {case.side} {case.name}: there is no check {name}" for name in case.checks if name not in known]
    errors += [f"no wrong {side} shows what {check.name} finds" for side, suite in suites.items() for check in suite.checks
               if not any(check.name in case.checks for case in cases(True) if case.side == side)]
    from ..page import PAGE
    text = PAGE.read_text(encoding="utf-8")
    found = re.search(r"```text\n((?:[0-9a-f]{2}[ \n])+)```", text)
    data = bytes.fromhex("".join(found.group(1).split())) if found else b""
    report = wire.RobotReport.FromString(data)
    if not data or report.SerializeToString() != data or report.robot_id != "agv":
        errors.append("the example's bytes are not read and written alike")
    if report.floor_hash != floor_hash([area("bay", 2, -0.5, 0.0, 3.0, 2.25)]):
        errors.append("the example's floor_hash is not that of the bay")
    return errors


def select(all_cases: list[Case], only: str | None) -> list[Case]:
    """The wrong ones with these names, separated by commas; all without."""
    if not only:
        return all_cases
    names = set(only.split(","))
    found = [case for case in all_cases if case.checks and case.name in names]
    missing = names - {case.name for case in found}
    if missing:
        print(f"--only: found {', '.join(sorted(missing))}, expected names of kit.selftest.robots.py or, with --mediator, of "
              "kit/selftest/mediators/__init__.py")
        raise SystemExit(2)
    return found


def main(arguments: Sequence[str]) -> int:
    """Runs the test. Returns the exit code."""
    options = argparse.ArgumentParser(prog="kit selftest", description=__doc__.split("\n")[0])
    options.add_argument("--only", metavar="NAME,...", help="these wrong ones alone, separated by commas")
    options.add_argument("--mediator", metavar="COMMAND", default="", help="test with mediators as well, made from this one by a relay; of the "
                         "site kit.toml, with {endpoint}, {prefix} and {folder} as for `kit mediator --start`")
    options.add_argument("--jobs", type=int, default=8, help="how many at a time; most of them wait most of the time [default: 8]")
    options.add_argument("--margin", default="1.0", metavar="S", help="as of `kit mediator` and `kit robot` [default: 1.0]")
    said = options.parse_args(arguments)
    begin, errors = time.monotonic(), page_errors() + identity_errors()
    print(*(errors or ["ok      sentences and example of PROTOCOL.md, files of identities"]), sep="\n", flush=True)
    chosen = select(cases(bool(said.mediator)), said.only)
    problems, runs = len(errors), Runs(said.mediator, said.margin)
    waiting = list(chosen)
    try:
        while waiting or len(runs) > 0:
            while waiting and len(runs) < said.jobs:
                runs.begin(waiting.pop(0))
            case, good, what = runs.ended()
            problems += not good
            print(f"{'ok' if good else 'FAILED':8}{case.side} {case.name}: {case.about} {what}", flush=True)
    finally:
        runs.end()
    if not said.mediator:
        print(f"skipped {len(WRONG_MEDIATORS)} wrong mediators: give --mediator COMMAND")
    wrong = {side: sum(case.side == side and bool(case.checks) for case in chosen) for side in ("robot", "mediator")}
    print(f"{wrong['robot']} wrong robots, {wrong['mediator']} wrong mediators, {problems} problems, in {time.monotonic() - begin:.0f} s")
    return 1 if problems else 0
