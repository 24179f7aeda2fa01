"""Robots that are wrong about areas, leases and revocations."""

from __future__ import annotations

from typing import Any

from ... import page
from ...levels import ENTERED, GRANTED, Claim
from ...robot import Robot


class EntersUngranted(Robot):
    """It takes a request for a grant."""

    def holds(self, area: str) -> bool:
        return area in self.claims


class NoLease(Robot):
    """It uses grants as long as it hears the mediator, whatever that has heard."""

    def has_lease(self, now: float) -> bool:
        return self.session != 0 and now <= self.heard_at + page.SILENT_S


class LeaseFromHearing(Robot):
    """Its lease runs from when the echo came, not from when the report was sent."""

    def renew_lease(self, echoed: int) -> None:
        if echoed in self.sent or echoed > 0 and echoed != getattr(self, "_echoed", 0):
            self.lease_from, self._echoed = self.heard_at, echoed


class LeaseBesideOthers(Robot):
    """Other mediators are nothing to it."""

    def note_other(self, message: Any, now: float) -> None:
        pass


class LeaseOfAnyNumber(Robot):
    """It takes any number that is not smaller than its own for an echo."""

    def renew_lease(self, echoed: int) -> None:
        super().renew_lease(min(echoed, self.sequence))


class NoFence(Robot):
    """It leaves out the fence when it releases."""

    def report(self, now: float) -> Any:
        report = super().report(now)
        for entry in report.access:
            if entry.level.progress > ENTERED:
                entry.fence = 0
        return report


class AsksTooEarly(Robot):
    """It begins the next run of an array by itself when the mediator has not done so for half a second."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.over_at: dict[tuple[str, int], float] = {}

    def step(self, now: float, seconds: float) -> None:
        for area, claim in list(self.claims.items()):
            if claim.is_over() and now > self.over_at.setdefault((area, claim.run), now) + 0.5:
                self.claims[area] = Claim(claim.run + 1)
        super().step(now, seconds)


class StaysInItsRun(Robot):
    """It believes in no run that it has not seen begin."""

    def learn_levels(self, message: Any, registers: bool) -> None:
        for entries, known, before in ((message.access, self.claims, 0), (message.revocations, self.revocations, -1)):
            for entry in list(entries):
                own = known[entry.area].run if entry.area in known else before
                if not registers and entry.level.run > own + 1 and not entry.level.after_abort:
                    entries.remove(entry)
        super().learn_levels(message, registers)


class DrivesOnWhenGivenUp(Robot):
    """It takes no notice of a run that is given up."""

    def may_move(self) -> bool:
        return self.located and bool(self.floor)


class NeverYields(Robot):
    """It keeps what is asked back."""

    def answer_revocations(self, committed: list[str]) -> None:
        super().answer_revocations(committed + list(self.claims))


class YieldsInside(Robot):
    """It gives back what is asked back although it is there."""

    def answer_revocations(self, committed: list[str]) -> None:
        for area, asked in self.revocations.items():
            if asked.progress == 1:
                asked.path, asked.progress = 0, 2
                if area in self.claims:
                    self.claims[area].path, self.claims[area].progress = 1, 3


class YieldsAnyFence(Robot):
    """It does not look at the fence of what is asked back."""

    def answer_revocations(self, committed: list[str]) -> None:
        for area, asked in self.revocations.items():
            if asked.progress == 1 and area in self.claims:
                asked.fence = self.claims[area].fence
        super().answer_revocations(committed)


class NeverAsksInside(Robot):
    """It does not ask for the area that it stands in."""

    def request(self, wanted: list[str]) -> None:
        super().request([area for area in wanted if area not in self.stands_in])

    def may_move(self) -> bool:
        return self.located and bool(self.floor)


class BelievesAnyFlag(Robot):
    """It takes over whatever flags a message says are set."""

    def learn_levels(self, message: Any, registers: bool) -> None:
        super().learn_levels(message, registers)
        for entry in message.access:
            claim = self.claims[entry.area]
            if claim.run == entry.level.run and claim.progress < entry.level.progress:
                claim.path, claim.progress, claim.fence = entry.level.path, entry.level.progress, entry.fence


class GoesBack(Robot):
    """It takes over less progress than it has."""

    def learn_levels(self, message: Any, registers: bool) -> None:
        super().learn_levels(message, registers)
        for entry in message.access:
            claim = self.claims[entry.area]
            if claim.run == entry.level.run and claim.progress == ENTERED and entry.level.progress < GRANTED:
                claim.progress, claim.fence = entry.level.progress, entry.fence


class SaysLevelsSeldom(Robot):
    """It leaves out in every other report what it has."""

    def report(self, now: float) -> Any:
        report = super().report(now)
        if self.sequence % 2:
            report.ClearField("access")
        return report


class ForgetsInSilence(Robot):
    """It has nothing any more when the mediator is silent."""

    def step(self, now: float, seconds: float) -> None:
        if self.session and not self.hears(now):
            self.claims = {}
        super().step(now, seconds)


class AnswersOnce(Robot):
    """It answers a revocation in one report."""

    def report(self, now: float) -> Any:
        report = super().report(now)
        answered = [area for area, asked in self.revocations.items() if asked.progress == 2]
        for area in answered:
            del self.revocations[area]
        return report
