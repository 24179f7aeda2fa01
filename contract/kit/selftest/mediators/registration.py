"""Mediators that take in, refuse or answer wrongly."""

from __future__ import annotations

import time
from typing import Any

from ... import page
from ...floor import HASH_OF_NOTHING
from .relay import Relay, set_level

ROBOTS = ("kit-1", "kit-2", "kit-3")


class ServesAnyVersion(Relay):
    """It takes in robots of other major versions."""

    def up(self, report: Any) -> Any:
        report.version.major = page.VERSION[0]
        return report


class DeafToFactsheets(Relay):
    """It does not take in reports that say what kind of robot it is."""

    def up(self, report: Any) -> Any:
        return None if report.HasField("factsheet") else report


class RefusesLaterMinor(Relay):
    """It refuses robots of a later minor version."""

    def up(self, report: Any) -> Any:
        report.version.major += report.version.minor > page.VERSION[1]
        return report


class ServesAnySite(Relay):
    """It takes in robots of other sites."""

    site = ""

    def up(self, report: Any) -> Any:
        self.site = report.site = self.site or report.site
        return report


class ServesAnyFloor(Relay):
    """It takes in robots with other floors."""

    def up(self, report: Any) -> Any:
        said = self.heard.get(report.robot_id)
        if said is not None and report.floor_hash not in (said.floor_hash, HASH_OF_NOTHING):
            report.floor_hash = said.floor_hash
            report.ClearField("floor")
        return report


class ServesStrangers(Relay):
    """It takes in robots that the site does not list."""

    def down(self, message: Any) -> Any:
        if message.robot_id not in ROBOTS:
            message.session, message.refusal = 1, ""
        return message


class ServesTheSecond(Relay):
    """It takes in a second process of a robot that it hears."""

    def down(self, message: Any) -> Any:
        if message.identity_taken:
            message.session, message.refusal, message.identity_taken = 10**6, "", False
        return message


class ServesTheDoubled(Relay):
    """It takes in the second of two processes once the first one ends."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.at: dict[tuple[str, int], float] = {}

    def up(self, report: Any) -> Any:
        self.at[report.robot_id, report.boot_epoch] = time.monotonic()
        return report

    def down(self, message: Any) -> Any:
        others = [at for (robot_id, boot), at in self.at.items() if robot_id == message.robot_id and boot != message.boot_epoch]
        if others and message.refusal and not message.floor and time.monotonic() > max(others) + page.SILENT_S:
            message.session, message.refusal, message.identity_taken = 10**6, "", False
        return message


class NeverDoubled(Relay):
    """It does not tell a robot that another one has its identity."""

    def down(self, message: Any) -> Any:
        message.identity_doubled = False
        return message


class NoReason(Relay):
    """It refuses without a reason."""

    def down(self, message: Any) -> Any:
        message.refusal = ""
        return message


class NoNameOfArea(Relay):
    """It does not say in which area the floors differ."""

    def down(self, message: Any) -> Any:
        message.refusal = message.refusal and "another floor"
        return message


class NoTakeUp(Relay):
    """It does not tell where the robot was heard last."""

    def down(self, message: Any) -> Any:
        message.ClearField("take_up")
        return message


class NoId(Relay):
    """It leaves the robot's id out."""

    def down(self, message: Any) -> Any:
        message.robot_id = ""
        return message


class SaysOtherVersion(Relay):
    """It says another version than it speaks."""

    def down(self, message: Any) -> Any:
        message.version.major = page.VERSION[0] - 1
        return message


class OtherFloorHash(Relay):
    """It says another hash of the floor than that of the areas."""

    def down(self, message: Any) -> Any:
        message.floor_hash ^= bool(message.session)
        return message


class FloorKept(Relay):
    """It gives its floor to the first robot alone."""

    given = False

    def down(self, message: Any) -> Any:
        if self.given:
            message.ClearField("floor")
        self.given |= bool(message.session)
        return message


class SessionStays(Relay):
    """It gives every process of a robot the same session."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.real_session: dict[int, int] = {}

    def down(self, message: Any) -> Any:
        if message.session:
            self.real_session[message.boot_epoch] = message.session
            message.session = self.instead(message)
        return message

    def up(self, report: Any) -> Any:
        if report.session:
            report.session = self.real_session.get(report.boot_epoch, report.session)
        return report

    def instead(self, message: Any) -> int:
        """What it says in place of the session."""
        return 1


class SessionsAnew(SessionStays):
    """It forgets with each start how far sessions were."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.boots: dict[str, list[int]] = {}

    def up(self, report: Any) -> Any:
        boots = self.boots.setdefault(report.robot_id, [])
        if report.boot_epoch not in boots:
            boots.append(report.boot_epoch)
        return super().up(report)

    def instead(self, message: Any) -> int:
        boots = self.boots.get(message.robot_id, [])
        return boots.index(message.boot_epoch) + 1 if message.boot_epoch in boots else 1


class OffersForGood(Relay):
    """It waits without end for a process to repeat the session that it was offered."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.offered: dict[str, int] = {}
        self.repeated: set[int] = set()

    def down(self, message: Any) -> Any:
        if message.session and message.boot_epoch not in self.repeated:
            self.offered[message.robot_id] = message.boot_epoch
        return message

    def up(self, report: Any) -> Any:
        if report.session:
            self.repeated.add(report.boot_epoch)
        awaited = self.offered.get(report.robot_id, report.boot_epoch)
        return report if awaited in (self.repeated | {report.boot_epoch}) else None


class EarlierSessions(Relay):
    """It takes reports of an earlier session for those of the present one."""

    def up(self, report: Any) -> Any:
        said = self.heard.get(report.robot_id)
        if said is not None and said.boot_epoch == report.boot_epoch and report.session:
            report.session = said.session
        return report


class LateBoots(Relay):
    """It takes a late report of the process before for one of the present process."""

    def up(self, report: Any) -> Any:
        said, newest = self.heard.get(report.robot_id), self.said.get(report.robot_id)
        if said is not None and newest is not None and report.session and said.session and report.session < said.session:
            report.boot_epoch, report.session, report.sequence = said.boot_epoch, said.session, newest.sequence + 1
        return report


class SpeaksFirst(Relay):
    """It sends to robots that it has not heard."""

    def down(self, message: Any) -> Any:
        for robot_id in ROBOTS:
            if robot_id not in self.said:
                self.send_down(robot_id, message)
        return message


class BelievesAtOnce(Relay):
    """After a start it believes each process, and grants what is asked for as soon as it has heard all robots."""

    since_s = 0.0

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.begin = time.monotonic()
        self.at: dict[str, float] = {}

    def up(self, report: Any) -> Any:
        if report.session:
            self.at[report.robot_id] = time.monotonic()
        return report

    def down(self, message: Any) -> Any:
        for one in message.access:
            heard = all(self.at.get(robot_id, 0.0) > self.begin + self.since_s for robot_id in ROBOTS)
            if heard and (one.level.path, one.level.progress) == (0, 1):
                set_level(one, one.level.run, 0, 2, 10**6)
        return message


class BelievesLateReports(BelievesAtOnce):
    """After a start it believes each process after 5 s, also in a report that was made before."""

    since_s = page.ENTERS_NO_MORE_S


class NoToken(Relay):
    """It declares no liveliness token."""

    def show_alive(self) -> None:
        pass
