"""The command line."""

from __future__ import annotations

import argparse
import random
import signal
import sys
from typing import Any, Sequence

from .checks import Suite, run_all
from .identity import NoLink
from .network import Network, free_endpoint
from .program import Program
from .shares import run_shares

SIGNALS = (signal.SIGTERM, signal.SIGHUP)
HINT = ("{endpoint}, {prefix} and {folder} in it stand for the endpoint to listen on or connect to, the key prefix, and a folder of its own "
        "that outlives a restart")


def end(number: int, _: Any) -> None:
    """As by an interrupt from the keyboard: programs that were started are ended, and what is known is said. A second signal changes nothing."""
    for other in SIGNALS:
        signal.signal(other, signal.SIG_IGN)
    sys.exit(128 + number)


def parser() -> argparse.ArgumentParser:
    """All options."""
    top = argparse.ArgumentParser(prog="kit", description="Tests one side of the fleet protocol by playing the other.")
    sides = top.add_subparsers(dest="side", required=True)
    mediator = sides.add_parser("mediator", help="play robots, and test a mediator")
    robot = sides.add_parser("robot", help="play the mediator, and test a robot")
    for side in (mediator, robot):
        side.add_argument("--list", action="store_true", help="list the checks with the sentences that they hold the other side to")
        side.add_argument("--markdown", action="store_true", help="with --list: as a table")
        side.add_argument("--only", metavar="NAME,...", help="run these checks alone")
        side.add_argument("--json", metavar="FILE", help="write the results there")
        side.add_argument("--start", metavar="COMMAND", help=f"start, kill and restart the program by this command line; {HINT}")
        side.add_argument("--jobs", type=int, default=1, metavar="N", help="with --start: so many programs at a time, each with its share of "
                          "the checks [default: 1]")
        side.add_argument("--prefix", help="key prefix [default: fleet; drawn with --start]")
        side.add_argument("--site", default="kit", help="name of the site [default: kit]")
        side.add_argument("--margin", type=float, default=1.0, metavar="S", help="added to each deadline of PROTOCOL.md for the network and "
                          "a busy machine, seconds [default: 1.0]")
    mediator.add_argument("--connect", metavar="ENDPOINT", help="where the mediator listens [with --start: a free port]")
    mediator.add_argument("--robots", default="kit-1,kit-2,kit-3", help="identities of all robots of the site [default: kit-1,kit-2,kit-3]")
    mediator.add_argument("--areas", default="", help="areas that no net lets robots into [default: all of the floor]")
    mediator.add_argument("--coordinated", metavar="ROBOT:STATE:AREA",
                          help="a robot is taken into a coordination when it reports this state and asks for this area")
    robot.add_argument("--listen", metavar="ENDPOINT", help="where the robot connects to [default: a free port]")
    robot.add_argument("--robot", default="kit-1", help="identity of the robot [default: kit-1]")
    robot.add_argument("--patience", type=float, default=30.0, metavar="S", help="until the robot drives up to the next border, seconds "
                       "[default: 30]")
    return top


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs a command. Returns the exit code."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    for number in SIGNALS:
        signal.signal(number, end)
    if words[:1] == ["selftest"]:
        from .selftest.run import main as selftest
        return selftest(words[1:])
    options = parser().parse_args(words)
    suite = suite_of(options.side)
    if options.list:
        print(suite.list(options.markdown))
        return 0
    errors = suite.errors()
    if errors:
        print("the kit does not fit PROTOCOL.md:", *errors, sep="\n  ")
        return 2
    checks = suite.select(options.only)
    prefix = options.prefix or (f"kit-{random.getrandbits(32):08x}" if options.start else "fleet")
    endpoint = (options.connect if options.side == "mediator" else options.listen) or ""
    if endpoint.startswith("tls/"):
        print(f"found the endpoint {endpoint}, expected tcp/HOST:PORT: the kit has no certificates; test on this computer, without them")
        return 2
    if options.jobs > 1 and (endpoint or not options.start):
        print(f"found --jobs {options.jobs}, expected --start with it, and no endpoint: each of them has a program of its own")
        return 2
    if options.jobs > 1:
        return run_shares(words, checks, options.jobs, options.json)
    try:
        return (test_mediator if options.side == "mediator" else test_robot)(options, checks, prefix)
    except NoLink as error:
        print(error)
        return 2


def suite_of(side: str) -> Suite:
    """The checks of a side."""
    if side == "mediator":
        from .of_mediator import SUITE
    else:
        from .of_robot import SUITE
    return SUITE


def test_mediator(options: argparse.Namespace, checks: list, prefix: str) -> int:
    """Plays robots."""
    from .fleet import Fleet, Settings
    if not options.connect and not options.start:
        print("found neither --connect nor --start, expected where the mediator listens, or how to start it")
        return 2
    endpoint = options.connect or free_endpoint()
    program = Program(options.start, endpoint=endpoint, prefix=prefix) if options.start else None
    split = [part for part in (options.coordinated or "").split(":") if part]
    if split and len(split) != 3:
        print(f"--coordinated: found `{options.coordinated}`, expected ROBOT:STATE:AREA")
        return 2
    settings = Settings(prefix, options.site, options.robots.split(","), [area for area in options.areas.split(",") if area], split,
                        options.margin)
    network = Network(connect=[endpoint])
    fleet = Fleet(network, settings, program)
    try:
        if program is not None:
            program.start(anew=True)
        return run_all(checks, fleet, options.json)
    finally:
        fleet.close()
        if program is not None:
            program.close()
        network.close()


def test_robot(options: argparse.Namespace, checks: list, prefix: str) -> int:
    """Plays the mediator."""
    from .hall import Hall
    endpoint = options.listen or free_endpoint()
    if not options.start:
        print(f"robot {options.robot} is awaited at {endpoint}, key prefix {prefix}", flush=True)
    network = Network(listen=[endpoint])
    program = Program(options.start, endpoint=endpoint, prefix=prefix) if options.start else None
    hall = Hall(network, prefix, options.site, options.robot, options.margin, options.patience, program)
    try:
        return run_all(checks, hall, options.json)
    finally:
        hall.close()
        if program is not None:
            program.close()
        network.close()
