"""Mediators that are wrong about areas."""

from __future__ import annotations

import time
from typing import Any

from ... import page, wire
from .relay import Relay, entry, held, set_level


class GrantsTwice(Relay):
    """It grants an area that another robot has."""

    def down(self, message: Any) -> Any:
        for one in message.access:
            if (one.level.path, one.level.progress) == (0, 1):
                set_level(one, one.level.run, 0, 2, 10**6)
        return message


class OneMoreInHall(Relay):
    """It grants an area for two to a third robot."""

    def down(self, message: Any) -> Any:
        for one in message.access:
            inside = sum(held(self.real(robot_id, one.area)) for robot_id in self.heard)
            if (one.level.path, one.level.progress) == (0, 1) and inside == 2:
                set_level(one, one.level.run, 0, 2, 10**6)
        return message


class FenceRepeats(Relay):
    """All its grants have one fence."""

    def down(self, message: Any) -> Any:
        for one in message.access:
            one.fence = 7 if one.fence else 0
        return message

    def up(self, report: Any) -> Any:
        for one in report.access:
            one.fence = self.real(report.robot_id, one.area).fence if one.fence else 0
        return report


class FenceFalls(Relay):
    """Its fences fall."""

    def down(self, message: Any) -> Any:
        for one in (*message.access, *message.revocations):
            one.fence = 10**6 - one.fence if one.fence else 0
        return message

    def up(self, report: Any) -> Any:
        for one in (*report.access, *report.revocations):
            one.fence = 10**6 - one.fence if one.fence else 0
        return report


class FencesAnew(Relay):
    """Its fences begin anew with each start."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.base: dict[str, int] = {}

    def down(self, message: Any) -> Any:
        for one in message.access:
            if one.fence:
                one.fence -= self.base.setdefault(one.area, one.fence - 1 if self.start > 1 else 0)
        return message

    def up(self, report: Any) -> Any:
        for one in report.access:
            one.fence += self.base.get(one.area, 0) if one.fence else 0
        return report


class NoFence(Relay):
    """It grants without a fence."""

    def down(self, message: Any) -> Any:
        for one in message.access:
            one.fence = 0
        return message

    def up(self, report: Any) -> Any:
        for one in report.access:
            one.fence = self.real(report.robot_id, one.area).fence if one.level.progress > 1 else 0
        return report


class AnyFence(Relay):
    """It does not look at fences."""

    def up(self, report: Any) -> Any:
        for one in report.access:
            real = self.real(report.robot_id, one.area)
            if one.level.progress > 2 and real.fence:
                one.fence = real.fence
        return report


class NotEmptied(Relay):
    """It does not empty an array after its last flag."""

    def down(self, message: Any) -> Any:
        said = self.said.get(message.robot_id)
        for one in message.access:
            last = entry(said.access, one.area) if said is not None else None
            if last is not None and last.level.run < one.level.run:
                set_level(one, last.level.run, last.level.path, last.level.progress, last.fence)
        return message


class GrantsUnasked(Relay):
    """It grants what nobody has asked for."""

    def down(self, message: Any) -> Any:
        for one in message.access:
            if one.level.run > 0 and one.level.progress == 0:
                set_level(one, one.level.run, 0, 2, 10**6)
        return message


class NeverSaysWhy(Relay):
    """It does not say what a robot waits for."""

    def down(self, message: Any) -> Any:
        for one in message.access:
            one.waits_for = ""
        return message


class EveryoneIsNext(Relay):
    """It tells everybody who waits that nobody comes first."""

    def down(self, message: Any) -> Any:
        for one in message.access:
            one.place = min(one.place, 1)
        return message


class BelievesGrants(Relay):
    """It takes a robot's word for it that it was granted an area."""

    def down(self, message: Any) -> Any:
        said = self.said.get(message.robot_id)
        for last in said.access if said is not None and said.session else ():
            one = entry(message.access, last.area)
            if held(last) and (one is None or one.level.progress < 2):
                one = one if one is not None else message.access.add(area=last.area)
                set_level(one, last.level.run, 0, last.level.progress, last.fence)
        return message


class OldReports(Relay):
    """It takes the report that comes last for the newest."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.count: dict[int, int] = {}
        self.most: dict[int, int] = {}

    def up(self, report: Any) -> Any:
        boot = report.boot_epoch
        self.most[boot] = max(report.sequence, self.most.get(boot, 0))
        report.sequence = self.count[boot] = self.count.get(boot, report.sequence - 1) + 1
        return report

    def down(self, message: Any) -> Any:
        if message.robot_sequence:
            message.robot_sequence = self.most.get(message.boot_epoch, 0)
        return message


class FarAhead(Relay):
    """It believes every number of a report."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.most: dict[int, int] = {}

    def up(self, report: Any) -> Any:
        most = self.most[report.boot_epoch] = max(report.sequence, self.most.get(report.boot_epoch, 0))
        return report if report.sequence == most else None


class CountsRequests(OldReports):
    """It takes every request that it hears for a new one, also one that comes again."""

    def up(self, report: Any) -> Any:
        for one in report.access:
            real = self.real(report.robot_id, one.area)
            if one.level.progress == 1 and one.level.run < real.level.run and real.level.progress == 0:
                one.level.run = real.level.run
        return super().up(report)


class OldRuns(Relay):
    """It does not look at which run a level is about."""

    def up(self, report: Any) -> Any:
        for one in report.access:
            real = self.real(report.robot_id, one.area)
            if one.level.run < real.level.run and real.level.progress > 1:
                set_level(one, real.level.run, one.level.path, one.level.progress, real.fence)
        return report


class GrantsAnything(Relay):
    """It grants areas that there are not."""

    def down(self, message: Any) -> Any:
        said = self.said.get(message.robot_id)
        for last in said.access if said is not None and message.session else ():
            if last.area.startswith("no-such-"):
                set_level(message.access.add(area=last.area), last.level.run, 0, 2, 1)
        return message


class LeftOutIsOver(Relay):
    """It takes an area that a report leaves out for given back."""

    def up(self, report: Any) -> Any:
        said = self.heard.get(report.robot_id)
        for real in said.access if said is not None and report.session == said.session else ():
            if held(real) and entry(report.access, real.area) is None:
                give_up(report, real)
        return report


def give_up(report: Any, real: Any) -> None:
    """Has a report end what its robot holds."""
    one = entry(report.access, real.area) or report.access.add(area=real.area)
    set_level(one, real.level.run, *((0, 4) if real.level.progress == 3 else (1, 3)), real.fence)
    del report.stands_in[:]


class NoPlaces(Relay):
    """It does not look at where robots stand."""

    def up(self, report: Any) -> Any:
        del report.stands_in[:]
        return report


class AlwaysLocated(Relay):
    """It takes a robot that does not know where it is for one that stands nowhere."""

    def up(self, report: Any) -> Any:
        report.located = True
        return report


class SilentIsGone(Relay):
    """It takes from a robot what it has when that has been silent for 1 s."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        # By boot: when it was heard, its newest report, and what it has.
        self.at: dict[int, tuple[float, Any]] = {}
        self.has: dict[int, list[Any]] = {}

    def up(self, report: Any) -> Any:
        self.at[report.boot_epoch] = (time.monotonic(), report)
        return report

    def down(self, message: Any) -> Any:
        self.has[message.boot_epoch] = [one for one in message.access if held(one)]
        return message

    def tick(self) -> None:
        for boot, (at, said) in list(self.at.items()):
            if time.monotonic() > at + page.SILENT_S and said.session:
                del self.at[boot]
                last = wire.RobotReport()
                last.CopyFrom(said)
                last.sequence += 1
                for real in self.has.get(boot, []):
                    give_up(last, real)
                del last.stands_in[:]
                self.send_up(last.robot_id, last.SerializeToString())


class AsksUnenteredBack(Relay):
    """It asks nothing back that was entered before, though the robot has left it."""

    def down(self, message: Any) -> Any:
        said = self.said.get(message.robot_id)
        entered = {one.area for one in (said.access if said is not None else ()) if (one.level.path, one.level.progress) == (0, 3)}
        asked = [one for one in message.revocations if one.area not in entered]
        message.ClearField("revocations")
        message.revocations.extend(asked)
        return message


class AsksBackOnce(Relay):
    """It asks an area back in one message, and waits."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.asked: set[tuple[str, str, int]] = set()

    def down(self, message: Any) -> Any:
        new = [one for one in message.revocations if (message.robot_id, one.area, one.level.run) not in self.asked]
        self.asked |= {(message.robot_id, one.area, one.level.run) for one in new}
        message.ClearField("revocations")
        message.revocations.extend(new)
        return message


class NeverAsksAgain(Relay):
    """It takes `kept` for the last word."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.asked: dict[tuple[str, str, int], int] = {}

    def down(self, message: Any) -> Any:
        first = [one for one in message.revocations
                 if self.asked.setdefault((message.robot_id, one.area, one.fence), one.level.run) == one.level.run]
        message.ClearField("revocations")
        message.revocations.extend(first)
        return message


class AsksOtherBack(Relay):
    """It asks another grant back than it means."""

    def down(self, message: Any) -> Any:
        for one in message.revocations:
            one.fence += 1
        return message


class TakesBack(Relay):
    """It asks an area back, and does not wait for the answer."""

    def up(self, report: Any) -> Any:
        said = self.heard.get(report.robot_id)
        for asked in said.revocations if said is not None else ():
            if asked.level.progress == 1:
                answer(report, asked, self.real(report.robot_id, asked.area))
        return report


class KeptIsYielded(Relay):
    """It takes `kept` for `yielded`."""

    def up(self, report: Any) -> Any:
        for one in report.revocations:
            if one.level.path == 1:
                answer(report, one, self.real(report.robot_id, one.area))
        return report


def answer(report: Any, asked: Any, real: Any) -> None:
    """Has a report say that its robot has yielded an area."""
    one = entry(report.revocations, asked.area) or report.revocations.add(area=asked.area)
    set_level(one, asked.level.run, 0, 2, asked.fence)
    if held(real):
        give_up(report, real)


class ForgetsAtStart(Relay):
    """It has forgotten after a start what robots have, and does not believe them."""

    def up(self, report: Any) -> Any:
        if self.start == 1:
            return report
        for one in report.access:
            real = self.real(report.robot_id, one.area)
            if held(one) and held(real):
                give_up(report, real)
        return report


class BelievesNobody(Relay):
    """It believes no grant that it does not know, not even after a start."""

    def up(self, report: Any) -> Any:
        known = [one for one in report.access if not held(one) or one.fence == self.real(report.robot_id, one.area).fence]
        report.ClearField("access")
        report.access.extend(known)
        return report


class BelievesKnownFences(Relay):
    """It believes after a start in grants of which its journal knows the end."""

    def up(self, report: Any) -> Any:
        if self.start > 1:
            for one in report.access:
                one.fence += 1 if one.level.progress == 3 else 0
        return report


class LeavesOutTooEarly(Relay):
    """It says once how an array rests, whether the robot has heard it or not."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.rests: set[tuple[int, str, int]] = set()

    def down(self, message: Any) -> Any:
        keys = [(message.boot_epoch, one.area, one.level.run) for one in message.access]
        kept = [one for one, key in zip(message.access, keys) if one.level.progress > 0 or key not in self.rests]
        self.rests |= {(message.boot_epoch, one.area, one.level.run) for one in kept if one.level.progress == 0}
        message.ClearField("access")
        message.access.extend(kept)
        return message


class SaysRunOnce(Relay):
    """It does not say its run again to a robot that names a smaller one."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.since: dict[tuple[int, str, int], int] = {}

    def down(self, message: Any) -> Any:
        acknowledged, kept = self.said[message.robot_id].mediator_sequence, []
        for one in message.access:
            since = self.since.setdefault((message.boot_epoch, one.area, one.level.run), message.sequence)
            if one.level.progress > 0 or acknowledged < since:
                kept.append(one)
        message.ClearField("access")
        message.access.extend(kept)
        return message
