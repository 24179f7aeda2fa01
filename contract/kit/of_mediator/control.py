"""Protocol 2: what a coordination says to the robot that it takes in."""

from __future__ import annotations

from typing import Any

from .. import page
from ..checks import Failed, Skipped
from ..fleet import Fleet, found, holds
from ..played_robot import Heard, PlayedRobot, next_flag
from . import SUITE

TAKES = ["--coordinated"]
ENDS = ("The first flags are `acquire` (mediator) and `acquired` (robot), the last ones `release` (mediator) and `released` (robot).")
ORDER = "they are set strictly in order."
FREE = "A `MediatorReport` without `control` means that the robot is free"
NUMBERS = "`coordination` numbers them; a larger number replaces a smaller one, whose flags are void."


def robot_of(fleet: Fleet) -> PlayedRobot:
    """The robot that a coordination takes in; it sets no flag by itself."""
    robot = next(robot for robot in fleet.robots if robot.robot_id == fleet.settings.coordinated[0])
    robot.plays_along = False
    return robot


def call(fleet: Fleet, robot: PlayedRobot) -> None:
    """Reports what makes the coordination take the robot in."""
    with robot.lock:
        robot.fsm_state = fleet.settings.coordinated[1]
        robot.request(fleet.settings.coordinated[2])


def controlled(heard: Heard) -> bool:
    """Whether the message has a coordination."""
    return bool(heard.message.HasField("control"))


def acquired(fleet: Fleet, robot: PlayedRobot) -> Any:
    """The coordination's first message."""
    call(fleet, robot)
    return fleet.expect(robot, fleet.soon_s, controlled, "a coordination, as the site has it").message.control


def answer(robot: PlayedRobot) -> None:
    """The robot sets its next flag."""
    with robot.lock:
        assert robot.control is not None
        robot.control = (robot.control[0], robot.control[1], robot.control[2] + 1)
        robot.send()


def play(fleet: Fleet, robot: PlayedRobot, answers: int | None = None) -> list[str]:
    """Plays the coordination on, with so many answers, else to its end. Returns the mediator's flags in the order of their coming."""
    flags: list[str] = []
    while answers is None or answers > 0:
        newest = robot.newest
        if newest is None or not controlled(newest) or robot.control is None:
            break
        control, (_, path, progress) = newest.message.control, robot.control
        order = list(control.paths[path].flags) if control.paths else list(range(len(control.flags)))
        flags.append(control.flags[order[progress - 1]].name)
        wanted = list(control.flags[order[progress - 1]].instruction.areas)
        for area in wanted:
            fleet.obtain(robot, area)
            robot.enter(area)
        following = next_flag(control, path, progress)
        if following is None or following.by_mediator:
            raise Failed("a flag of the robot next, after one of the mediator", found(robot))
        answer(robot)
        for area in wanted:
            robot.leave(area)
        mine = progress + 1
        fleet.expect(robot, fleet.soon_s, lambda heard, mine=mine: not controlled(heard) or heard.message.control.level.progress > mine,
                     f"the next flag, or no control, after {following.name}")
        answers = None if answers is None else answers - 1
    return flags


@SUITE.check("without-control", "A robot that knows no protocol 2 says so in every report, `without_control`: no coordination takes it in.",
             needs=TAKES)
def without_control(fleet: Fleet) -> None:
    """A robot without protocol 2 is taken into no coordination, although all else is as the coordination wants it."""
    robot = robot_of(fleet)
    robot.without_control = True
    sent = robot.send()
    fleet.expect(robot, fleet.soon_s, lambda heard: heard.message.robot_sequence >= sent, "the report to count")
    call(fleet, robot)
    fleet.never(robot, 2 * fleet.watch_s, controlled, "no control to a robot without protocol 2")
    robot.fsm_state = "idle"


@SUITE.check("acquire-first", ENDS, "The mediator sends it whole in `control`: the net's flags, the paths that they can take, and its level",
             needs=TAKES)
def acquire_first(fleet: Fleet) -> None:
    """A coordination begins with `acquire` set and no more, and every path goes from acquire and acquired to release and released."""
    robot = robot_of(fleet)
    control = acquired(fleet, robot)
    paths = [list(path.flags) for path in control.paths] or [list(range(len(control.flags)))]
    for path in paths:
        named = [(control.flags[at].name, control.flags[at].by_mediator) for at in path]
        if named[:2] != [("acquire", True), ("acquired", False)] or named[-2:] != [("release", True), ("released", False)]:
            raise Failed("acquire (mediator), acquired (robot), ..., release (mediator), released (robot)", f"{named}")
    if (control.level.run, control.level.progress) != (0, 1) or control.coordination < 1:
        raise Failed("run 0, progress 1, and a number of at least 1", f"{control.level}, number {control.coordination}".replace("\n", " "))


@SUITE.check("flags-in-order", ORDER, "A level may add only flags of its sender.", needs=TAKES)
def flags_in_order(fleet: Fleet) -> None:
    """The mediator sets no flag of the robot, and none before the robot has set those before it."""
    robot = robot_of(fleet)
    acquired(fleet, robot)
    fleet.never(robot, fleet.watch_s, lambda heard: controlled(heard) and heard.message.control.level.progress > 1,
                "progress 1 until the robot answers")
    answer(robot)
    fleet.expect(robot, fleet.soon_s, lambda heard: controlled(heard) and heard.message.control.level.progress >= 3, "the next flag")
    fleet.never(robot, fleet.watch_s, lambda heard: controlled(heard) and heard.message.control.level.progress > 3,
                "progress 3 until the robot answers")


@SUITE.check("no-flag-of-others", "A level may add only flags of its sender. One that claims yours is wrong: ignore it, and count it.", needs=TAKES)
def no_flag_of_others(fleet: Fleet) -> None:
    """A robot that claims the mediator's flags too does not bring the coordination on."""
    robot = robot_of(fleet)
    control = acquired(fleet, robot)
    with robot.lock:
        robot.control = (control.coordination, 0, len(control.flags))
        robot.send()
    fleet.never(robot, fleet.watch_s, lambda heard: not controlled(heard) or heard.message.control.level.progress > 1,
                "progress 1, since the robot's level claims flags of the mediator")
    with robot.lock:
        robot.control = (control.coordination, 0, 1)


@SUITE.check("other-coordination", NUMBERS, needs=TAKES)
def other_coordination(fleet: Fleet) -> None:
    """`acquired` with the number of another coordination says nothing."""
    robot = robot_of(fleet)
    control = acquired(fleet, robot)
    robot.follows = False
    for number in (control.coordination - 1, control.coordination + 1):
        with robot.lock:
            robot.control = (number, 0, 2)
            robot.send()
        fleet.never(robot, page.SILENT_S, lambda heard: not controlled(heard) or heard.message.control.level.progress > 1,
                    f"progress 1, since the answer is of coordination {number}, not {control.coordination}")
    robot.control, robot.follows = (control.coordination, 0, 1), True


@SUITE.check("played-to-its-end", FREE, "ask for `areas` by protocol 1, whose grants are kept for it", ENDS, needs=TAKES)
def played_to_its_end(fleet: Fleet) -> None:
    """The areas of orders are granted, `release` is the mediator's last flag, and after `released` there is no control."""
    robot = robot_of(fleet)
    acquired(fleet, robot)
    robot.fsm_state = "idle"
    flags = play(fleet, robot)
    if flags[0] != "acquire" or flags[-1] != "release":
        raise Failed("from acquire to release", f"{flags}")
    fleet.never(robot, fleet.watch_s, controlled, "no control: it is free")


@SUITE.check("order-needs-grant", "As always, an instruction's area may be entered only when it is granted.", "| 0 | `request` (robot), "
             "`granted` (mediator)", needs=TAKES)
def order_needs_grant(fleet: Fleet) -> None:
    """An order's area is kept for the robot, and nobody else gets it when it asks first."""
    robot = robot_of(fleet)
    other = next(other for other in fleet.robots if other is not robot)
    acquired(fleet, robot)
    robot.give_back_all()
    robot.plays_along = False
    answer(robot)
    heard = fleet.expect(robot, fleet.soon_s, lambda heard: controlled(heard) and heard.message.control.level.progress >= 3, "the first order")
    areas = [area for flag in heard.message.control.flags for area in flag.instruction.areas]
    if not areas:
        raise Skipped("the coordination's first order names no area")
    other.request(areas[0])
    fleet.refused(other, areas[0], f"it is kept for {robot.robot_id}, whose order names it")
    if robot.claims[areas[0]].progress == 0:
        robot.request(areas[0])
    fleet.expect(robot, fleet.soon_s, holds(areas[0]), f"a grant of {areas[0]} to {robot.robot_id}, whose order names it")


@SUITE.check("coordination-grows", NUMBERS, "| `coordination` | 1 | with every coordination of the site | 2^62 |", needs=TAKES)
def coordination_grows(fleet: Fleet) -> None:
    """The next coordination has a larger number."""
    robot = robot_of(fleet)
    numbers = []
    for _ in range(2):
        numbers.append(acquired(fleet, robot).coordination)
        robot.fsm_state = "idle"
        play(fleet, robot)
    if numbers[1] <= numbers[0]:
        raise Failed(f"a number above {numbers[0]}", str(numbers[1]))


# The last one: the robot is not taken in again for a minute.
@SUITE.check("acquire-times-out", "the coordination ends otherwise, so that it does not hold the others, and none takes the robot in for 60 s.",
             "| `acquire` is answered within | 5 s |", needs=TAKES)
def acquire_times_out(fleet: Fleet) -> None:
    """A coordination whose `acquire` is not answered ends after 5 s and not earlier, and the robot is not taken in again."""
    robot = robot_of(fleet)
    acquired(fleet, robot)
    fleet.never(robot, page.ACQUIRED_S - 0.7, lambda heard: not controlled(heard), "control for 5 s")
    fleet.expect(robot, 0.7 + fleet.soon_s, lambda heard: not controlled(heard), "no control after 5 s without an answer")
    fleet.never(robot, 2 * page.ACQUIRED_S, controlled, "no control for 60 s, of which it is watched for 10 s")
    robot.fsm_state = "idle"
