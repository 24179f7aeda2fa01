"""Protocol 2: what a robot does when a coordination takes it in."""

from __future__ import annotations

import time
from typing import Any, Sequence

from .. import page, wire
from ..checks import Failed, Skipped
from ..hall import Hall, Said
from . import SUITE

ACQUIRE = "One that does not say so answers `acquire` within 5 s"
ALONE = "the robot answers with number and level alone."
ASKS = ("It asks for no areas but those it stands in, those it can no longer stop before, and those of instructions; it returns the other "
        "grants that it has not entered.")
OUTPUT = "The robot sets its next flag when its state machine fires the output named in `on_output`; where none is named, as soon as it is next."
FREE = "A `MediatorReport` without `control` means that the robot is free: it forgets the coordination"
NUMBERS = "`coordination` numbers them; a larger number replaces a smaller one, whose flags are void."
ORDER = "and ask for `areas` by protocol 1, whose grants are kept for it"
# (name, by_mediator, areas, on_output)
Flags = Sequence[tuple[str, bool, Sequence[str], str]]
PLAIN: Flags = (("acquire", True, (), ""), ("acquired", False, (), ""), ("release", True, (), ""), ("released", False, (), ""))


def begin(hall: Hall, flags: Flags = PLAIN) -> int:
    """Begins a coordination with a number that was not used, at `acquire`. Returns the number."""
    if hall.said[-1].report.without_control:
        raise Skipped("the robot says `without_control`: it knows no protocol 2")
    with hall.lock:
        hall.coordination = number = hall.coordination + 1
        control = wire.Control(coordination=number, net="kit", level=wire.Level(progress=1))
        for name, by_mediator, areas, output in flags:
            flag = control.flags.add(name=name, by_mediator=by_mediator, on_output=output)
            if areas:
                flag.instruction.areas.extend(areas)
        control.paths.add(flags=range(len(flags)))
        hall.control = control
        hall.send()
    return number


def go_on(hall: Hall, progress: int) -> None:
    """The mediator sets its next flag."""
    with hall.lock:
        hall.control.level.progress = progress
        hall.send()


def at(number: int, progress: int) -> Any:
    """Whether a report answers this coordination with this progress."""
    def judge(said: Said) -> bool:
        control = said.report.control
        return said.report.HasField("control") and (control.coordination, control.level.progress) == (number, progress)

    return judge


def acquired(hall: Hall, flags: Flags = PLAIN) -> int:
    """Begins a coordination, and waits for `acquired`."""
    number = begin(hall, flags)
    hall.expect(page.ACQUIRED_S, at(number, 2), f"`acquired` of coordination {number}")
    return number


def finish(hall: Hall) -> None:
    """The coordination is over."""
    with hall.lock:
        hall.control = None
        hall.send()
    hall.expect(hall.soon_s, lambda said: not said.report.HasField("control"), "no coordination any more")


@SUITE.check("acquired-in-time", ACQUIRE, ALONE)
def acquired_in_time(hall: Hall) -> None:
    """`acquire` is answered within 5 s, with number and level alone, as run 0."""
    acquired(hall)
    control = hall.said[-1].report.control
    if control.net or control.flags or control.paths or control.level.run != 0:
        raise Failed("number and level, run 0", f"{control}".replace("\n", " "))
    finish(hall)


@SUITE.check("acquired-asks-for-nothing", ASKS)
def asks_for_nothing(hall: Hall) -> None:
    """While it is acquired it asks for no area but where it stands, and returns what it has not entered."""
    area = hall.ahead()
    hall.stands_still()
    hall.echoes = False
    time.sleep(page.LEASE_S + 2 * page.LEVEL_S)
    hall.let_into(area)
    grant = hall.levels[area]
    hall.expect(hall.soon_s, lambda said: said.access(area) == grant, f"the grant {grant} repeated")
    hall.full = {area}
    hall.grants = lambda name: name in hall.stands_in()
    acquired(hall)
    hall.expect(hall.soon_s, lambda said: said.access(area) == grant.then(3, path=1), f"{area} returned, which it has not entered")
    with hall.lock:
        hall.echoes, hall.full = True, set()
    time.sleep(hall.soon_s)

    def asks(said: Said) -> bool:
        return any(entry.level.progress in (1, 2) and entry.level.path == 0 and entry.area not in said.report.stands_in
                   for entry in said.report.access)

    hall.never(3.0, asks, "no request for an area in which it does not stand")
    finish(hall)


@SUITE.check("order-asks-for-areas", ORDER, "As always, an instruction's area may be entered only when it is granted.")
def order_asks(hall: Hall) -> None:
    """An order's area is asked for, and not entered before it is granted."""
    asked = hall.ahead()
    # One that it has not asked for already, if there is one.
    area = next((area.id for area in hall.floor if area.id != asked and area.id not in hall.stands_in()), asked)
    flags = (*PLAIN[:2], ("e1", True, (area,), ""), ("done1", False, (), "kit-never-fires"), *PLAIN[2:])
    before = hall.stands_in()
    acquired(hall, flags)
    go_on(hall, 3)
    hall.expect(hall.soon_s, lambda said: hall.asks(said, area), f"a request for {area}, which the order names")
    hall.never(3.0, lambda said: not hall.asks(said, area) or not set(said.report.stands_in) <= before, f"{area} asked for, and not entered")
    finish(hall)


@SUITE.check("waits-for-output", OUTPUT)
def waits_for_output(hall: Hall) -> None:
    """A flag that waits for an output which never fires is not set; one that waits for none is set as soon as it is next."""
    hall.ahead()
    flags = (*PLAIN[:2], ("e1", True, (), ""), ("done1", False, (), ""), ("e2", True, (), ""), ("done2", False, (), "kit-never-fires"), *PLAIN[2:])
    number = acquired(hall, flags)
    go_on(hall, 3)
    hall.expect(hall.soon_s, at(number, 4), "done1, which waits for no output")
    go_on(hall, 5)
    hall.never(3.0, lambda said: not said.report.HasField("control") or said.report.control.level.progress > 5,
               "done2 not set, whose output does not fire")
    finish(hall)


@SUITE.check("released-and-free", FREE, "From `acquire` until it has set `released`, the robot's state machine goes on")
def released_and_free(hall: Hall) -> None:
    """After `release` it sets `released`; without control it forgets the coordination and asks for areas again."""
    hall.ahead()
    number = acquired(hall)
    go_on(hall, 3)
    hall.expect(hall.soon_s, at(number, 4), "`released`")
    finish(hall)
    hall.ahead()


@SUITE.check("control-gone-is-free", FREE)
def control_gone(hall: Hall) -> None:
    """A coordination that ends without `release` leaves the robot free as well."""
    hall.ahead()
    acquired(hall)
    finish(hall)
    hall.ahead()


@SUITE.check("larger-coordination", NUMBERS)
def larger_coordination(hall: Hall) -> None:
    """A coordination with a larger number replaces the one before; a smaller number then says nothing."""
    hall.ahead()
    first = acquired(hall)
    second = acquired(hall)
    with hall.lock:
        hall.control.coordination = first
        hall.send()
    hall.never(hall.watch_s, lambda said: said.report.HasField("control") and said.report.control.coordination == first,
               f"coordination {second}, not the smaller {first} again")
    with hall.lock:
        hall.control.coordination = second
    finish(hall)


@SUITE.check("sets-own-flags-alone", "they are set strictly in order.", "A level may add only flags of its sender.")
def own_flags_alone(hall: Hall) -> None:
    """After `acquired` it sets nothing until the mediator has set its next flag."""
    hall.ahead()
    number = acquired(hall)
    hall.never(hall.watch_s, lambda said: not at(number, 2)(said), "progress 2 until the mediator sets `release`")
    go_on(hall, 4)
    hall.never(hall.watch_s, lambda said: not at(number, 2)(said), "progress 2: the message claims the robot's `released`")
    with hall.lock:
        hall.control.level.progress = 2
    finish(hall)
