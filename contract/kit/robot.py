"""A robot of another vendor, as an example: `python -m kit.robot --connect tls/HOST:7447 --identity FILE --site SITE --id ID --at X,Y
--route A,B,C`; without certificates `--connect tcp/HOST:7447` alone.

It brings no file of the site: floor and role come from the mediator. It drives from the middle of one area of its route to that of the
next, there and back, on a simulated body; with `--round` from the last on to the first. A stop may have a place: `lane@2.5:-0.6`. `--at` is
the word of the person who starts it, who sees it stand there: never write it into what restarts the program by itself. Without it the robot
is not located, stands, and shows where it was heard last, until it reads `at X Y` on its standard input.

Its machine knows three states: `drive` on its route; `visit`, by an order with areas, to the middle of the last one or to the order's place
to stop, with the output `arrived`; and `halt`, by the event `halt`, until `resume`.
"""

from __future__ import annotations

import argparse
import math
import sys
import threading
import time
from dataclasses import replace
from typing import Any, Callable

from . import page, wire
from .body import MARGIN_M, Body, centre, reaches
from .following import Follower
from .identity import NoLink
from .levels import ENTERED, GRANTED, RELEASED, REQUESTED, RETURNED, Claim, Coordination
from .link import Link

# A robot asks so early that it need not brake when the grant comes at once.
ASKS_AHEAD_M = 0.8
# It stands this much before a border.
GAP_M = 0.05


class Robot(Follower):
    """All that the robot says and does; no network and no clock of its own. Seconds are those of one monotonic clock."""

    def __init__(self, robot_id: str, site: str, body: Body, route: list[str], located: bool, round_trip: bool = False) -> None:
        super().__init__(robot_id)
        self.site, self.body, self.located = site, body, located
        self.stops = route if round_trip else [*route, *route[-2:0:-1]]
        self.state_sequence = 0
        # What it has.
        self.claims: dict[str, Claim] = {}
        self.revocations: dict[str, Claim] = {}
        self.coordination: Coordination | None = None
        # The order that holds, and the one that was begun.
        self.order: Any = None
        self.begun: Any = None
        self.stands_in: list[str] = []
        self.state = "drive"
        self.target = 0

    def is_placed(self, x_m: float, y_m: float) -> None:
        """Somebody says where it stands. What it has, or asks for, it may have because it was thought elsewhere."""
        self.body.x_m, self.body.y_m, self.body.path, self.located = x_m, y_m, [], True
        for claim in self.claims.values():
            claim.inherited = claim.held or claim.progress == REQUESTED

    def forget(self) -> None:
        """It has nothing."""
        self.claims, self.revocations, self.coordination = {}, {}, None

    def learn_levels(self, message: Any, registers: bool) -> None:
        """Takes in levels of protocol 1; at a registration as they are."""
        for entries, known, mine in ((message.access, self.claims, GRANTED), (message.revocations, self.revocations, 1)):
            for entry in entries:
                if registers:
                    known[entry.area] = Claim.inherit(entry)
                elif not known.setdefault(entry.area, Claim()).learn(entry, mine):
                    self.wrong += 1

    def contradicts(self, message: Any) -> bool:
        """Whether a level cannot follow what this process has said."""
        return not all(replace(self.claims.get(entry.area, Claim())).learn(entry, GRANTED, strict=True) for entry in message.access)

    def learn_control(self, message: Any, registers: bool) -> None:
        """Takes in protocol 2. A robot that has just registered carries the last instruction out again."""
        own = self.coordination
        if not message.HasField("control"):
            if own is not None:
                self.coordination, self.order = None, own.release_order() or self.order
        elif own is None or message.control.coordination > own.number:
            self.coordination = Coordination(message.control)
        elif message.control.coordination == own.number and not own.learn(message.control):
            self.wrong += 1

    def holds(self, area: str) -> bool:
        """Whether the area was granted to this process."""
        claim = self.claims.get(area)
        return claim is not None and claim.held and not claim.inherited

    # ------------------------------------------------------------ time

    def step(self, now: float, seconds: float) -> None:
        """Lets time pass: orders, machine, areas, and then the body."""
        self.carry_out_orders()
        self.step_machine()
        body = self.body
        where = [area.id for area in self.floor if reaches(area, body.x_m, body.y_m)]
        self.news |= where != self.stands_in
        self.stands_in = where
        ahead = self.areas_ahead()
        committed = [area for area, far in ahead if self.holds(area) and far <= body.braking_m()]
        if self.located and self.session:
            wanted = [*self.stands_in, *committed, *self.wanted(ahead)]
            self.answer_revocations(committed)
            self.set_flags(wanted, committed)
            if self.hears(now):
                self.request(wanted)
        free = 0.0 if not self.may_move() else math.inf
        for area, far in ahead:
            if not self.holds(area) or not self.has_lease(now) and area not in committed:
                free = min(free, far - GAP_M)
        body.step(seconds, free)

    def may_move(self) -> bool:
        """It knows where it is, speaks for its identity, and stands in nothing that it does not have."""
        return self.located and not self.identity_taken and bool(self.floor) and all(self.holds(area) for area in self.stands_in)

    def areas_ahead(self) -> list[tuple[str, float]]:
        """Areas that its way leads into, with how far it is until it reaches in, beginning with the nearest."""
        first: dict[str, float] = {}
        for far, x, y in self.body.ahead(self.body.braking_m(self.body.max_speed_m_s) + ASKS_AHEAD_M):
            for area in self.floor:
                if area.id not in self.stands_in and area.id not in first and reaches(area, x, y):
                    first[area.id] = far
        return sorted(first.items(), key=lambda item: item[1])

    def wanted(self, ahead: list[tuple[str, float]]) -> list[str]:
        """What to ask for, beside what it needs in any case. One that is acquired asks for areas of its orders alone."""
        if self.coordination is not None and self.coordination.acquired:
            return self.ordered_areas()
        return [area for area, _ in ahead]

    def ordered_areas(self) -> list[str]:
        """Areas of the order that is being carried out."""
        return list(self.order.areas) if self.order is not None else []

    def answer_revocations(self, committed: list[str]) -> None:
        """Gives back what is asked back, unless it is there or can no longer stop before it."""
        for area, asked in self.revocations.items():
            if asked.progress != 1 or asked.path != 0:
                continue
            claim = self.claims.get(area)
            has = claim is not None and claim.held and claim.fence == asked.fence
            if has and claim is not None and (area in self.stands_in or area in committed):
                asked.path, asked.progress = 1, 2
            else:
                asked.path, asked.progress = 0, 2
                if has and claim is not None:
                    claim.path, claim.progress = (0, RELEASED) if claim.progress == ENTERED else RETURNED
            self.news = True

    def set_flags(self, wanted: list[str], committed: list[str]) -> None:
        """Sets `entered`, `released` and `returned` by where it is."""
        for area, claim in self.claims.items():
            before = (claim.path, claim.progress)
            stands = area in self.stands_in
            if claim.held and stands:
                claim.progress, claim.inherited = ENTERED, False
            elif claim.held and claim.progress == ENTERED:
                claim.progress = RELEASED
            elif claim.held and (claim.inherited or area not in wanted) and area not in committed:
                claim.path, claim.progress = RETURNED
            self.news |= before != (claim.path, claim.progress)

    def request(self, wanted: list[str]) -> None:
        """Asks for what is wanted, beginning with where it stands."""
        for area in wanted:
            claim = self.claims.setdefault(area, Claim())
            if claim.progress == 0:
                claim.progress, claim.path, claim.fence, self.news = REQUESTED, 0, 0, True

    # ------------------------------------------------------------ the machine

    def post(self, event: str) -> None:
        """An event of the machine; one without a transition is dropped."""
        self.state = {"halt": "halt", "resume": "drive"}.get(event, self.state)
        self.body.path.clear()

    def fire(self, output: str) -> None:
        """An output of the machine."""
        if self.coordination is not None:
            self.coordination.output(output)

    def carry_out_orders(self) -> None:
        """Takes the newest order, and then sets the flags that say so."""
        if self.coordination is not None and self.session:
            order = self.coordination.next_order()
            self.order = order if order is not None else self.order
        if self.order is not None and self.order is not self.begun:
            self.begun = self.order
            if self.order.event:
                self.post(self.order.event)
            if self.order.areas:
                self.state = "visit"
                self.body.path = [centre(area) for name in self.order.areas for area in self.floor if area.id == name]
                if self.order.HasField("stop_at"):
                    self.body.path[-1:] = [(self.order.stop_at.x_m, self.order.stop_at.y_m)]
        if self.coordination is not None and self.session:
            self.news |= self.coordination.advance()
        if self.coordination is None and self.order is not None:
            self.state, self.order = ("drive" if self.state == "visit" else self.state), None

    def step_machine(self) -> None:
        """Goes on to the next area of the route, and fires what has come."""
        limit = self.order.speed_limit_m_s if self.order is not None else 0.0
        self.body.max_speed_m_s = min(limit, self.speed_m_s) if limit > 0 else self.speed_m_s
        if self.state == "halt":
            self.body.path.clear()
        elif self.state == "visit" and not self.body.path:
            self.fire("arrived")
        elif self.state == "drive" and not self.body.path and self.floor and len(self.stops) > 1:
            self.target = (self.target + 1) % len(self.stops)
            name, _, place = self.stops[self.target].partition("@")
            if place:
                x_m, y_m = (float(part) for part in place.split(":"))
                self.body.path = [(x_m, y_m)]
            else:
                self.body.path = [centre(area) for area in self.floor if area.id == name]

    @property
    def speed_m_s(self) -> float:
        """What it drives at most."""
        return 0.5

    # ------------------------------------------------------------ reports

    def report(self, now: float) -> Any:
        """The next report, which counts as sent now."""
        self.sequence, self.news = self.sequence + 1, False
        self.sent = {sequence: at for sequence, at in self.sent.items() if at > now - page.LEASE_S}
        self.sent[self.sequence] = now
        report = wire.RobotReport(
            version=wire.Version(major=page.VERSION[0], minor=page.VERSION[1]), robot_id=self.robot_id, boot_epoch=self.boot_epoch, sequence=self.sequence,
            site=self.site, mediator_epoch=self.epoch, session=self.session, stands_in=self.stands_in, located=self.located, pose=self.pose(),
            fsm_state=self.state, mediator_sequence=self.heard_sequence, mediator_instance=self.instance, mediator_heard=self.hears(now),
            mediator_journal=self.journal, floor_hash=self.floor_hash, floor=[] if self.session else self.floor)
        for known, entries in ((self.claims, report.access), (self.revocations, report.revocations)):
            for area, claim in known.items():
                claim.say(area, entries)
        if self.coordination is not None:
            report.control.coordination = self.coordination.number
            report.control.level.path, report.control.level.progress = self.coordination.path, self.coordination.progress
        return report

    def say_state(self, now: float) -> Any:
        """What it tells everybody."""
        self.state_sequence += 1
        return wire.RobotState(
            robot_id=self.robot_id, boot_epoch=self.boot_epoch, sequence=self.state_sequence, stamp_ns=int(now * 1e9), pose=self.pose(),
            speed_m_s=self.body.speed_m_s, fsm_state=self.state, area=self.stands_in[0] if self.stands_in else "", mode="running")

    def pose(self) -> Any:
        """Where it is; how sure it is goes with the margin that it keeps."""
        return wire.Pose(x_m=self.body.x_m, y_m=self.body.y_m, std_x_m=MARGIN_M / 3, std_y_m=MARGIN_M / 3)


def now_s() -> float:
    """The clock of the lease, which goes on while the computer sleeps."""
    return time.clock_gettime(time.CLOCK_BOOTTIME)


def run(make: Callable[..., Robot], arguments: list[str] | None = None, connect: Callable[..., Link] = Link) -> None:
    """Joins robot, network and clock, until the process ends."""
    options = argparse.ArgumentParser(prog="kit.robot", description=__doc__.split("\n")[0])
    for name, default in (("connect", None), ("identity", ""), ("prefix", "fleet"), ("site", "kit"), ("id", "kit-1"), ("at", ""),
                          ("route", "a,b,c,d")):
        options.add_argument(f"--{name}", default=default, required=default is None)
    options.add_argument("--round", action="store_true")
    said = options.parse_args(arguments)
    x_m, y_m = (float(part) for part in (said.at or "0,0").split(","))
    robot = make(said.id, said.site, Body(x_m, y_m), said.route.split(","), bool(said.at), said.round)
    lock = threading.Lock()

    def take(data: bytes) -> None:
        with lock:
            robot.receive(data, now_s())

    def listen() -> None:
        for line in sys.stdin:
            word, *numbers = line.split()
            if word == "at" and len(numbers) == 2:
                with lock:
                    robot.is_placed(*(float(number) for number in numbers))

    try:
        link = connect(said.connect, said.prefix, said.id, said.identity, take)
    except NoLink as error:
        options.error(str(error))
    threading.Thread(target=listen, daemon=True).start()
    before = sent = now_s()
    while True:
        time.sleep(0.02)
        now = now_s()
        with lock:
            # A process that was held up goes no farther for it.
            robot.step(now, min(now - before, 0.04))
            due = now >= sent + page.LEVEL_S * 0.9
            if robot.news or due:
                link.put("report", robot.report(now))
            if due:
                sent = now
                link.put("state", robot.say_state(now))
        before = now


if __name__ == "__main__":
    run(Robot)
