"""Robots that follow the wrong mediator, or none."""

from __future__ import annotations

from typing import Any

from ... import page
from ...robot import Robot


class BelievesNonsense(Robot):
    """It believes every number."""

    def is_plausible(self, message: Any, now: float) -> bool:
        return True


class FollowsNameless(Robot):
    """It follows a mediator without a number."""

    def is_plausible(self, message: Any, now: float) -> bool:
        return super().is_plausible(message, now) or message.instance == 0


class CountsOnlyItself(Robot):
    """Its numbers are its own, whatever the mediator has heard in its name."""

    def renew_lease(self, echoed: int) -> None:
        before = self.sequence
        super().renew_lease(echoed)
        self.sequence = before


class FollowsAnybody(Robot):
    """It follows whoever speaks."""

    def may_follow(self, message: Any, now: float) -> bool:
        return True


class TakesLateOffers(Robot):
    """It takes whatever session it is offered when it has none."""

    def may_follow(self, message: Any, now: float) -> bool:
        return self.session == 0 and message.session != 0 or super().may_follow(message, now)


class TakesRefusals(Robot):
    """It follows a mediator that refuses it, once its own is silent."""

    def may_follow(self, message: Any, now: float) -> bool:
        silent = now > self.heard_at + page.SILENT_S
        return super().may_follow(message, now) or silent and message.session == 0 and message.mediator_epoch > self.epoch


class FollowsSmallerEpochs(Robot):
    """It follows any other mediator once its own is silent."""

    def may_follow(self, message: Any, now: float) -> bool:
        return now > self.heard_at + page.SILENT_S


class NeverFollows(Robot):
    """It never follows another process of the mediator."""

    def may_follow(self, message: Any, now: float) -> bool:
        return self.session == 0


class ForgetsOnRestart(Robot):
    """It takes what a restarted mediator knows for all there is."""

    def receive(self, data: bytes, now: float) -> None:
        before = self.instance
        super().receive(data, now)
        if before not in (0, self.instance):
            self.claims = {}


class LooksAtSequenceAlone(Robot):
    """It takes the message with the largest sequence for the newest, whichever epoch it is of."""

    def is_for_me(self, message: Any) -> bool:
        old = message.instance == self.instance and message.sequence <= self.heard_sequence
        return message.robot_id == self.robot_id and message.boot_epoch == self.boot_epoch and not old


class KeepsEpoch(Robot):
    """It ignores a larger epoch of the mediator that it follows."""

    def is_plausible(self, message: Any, now: float) -> bool:
        return super().is_plausible(message, now) and not (message.instance == self.instance and message.mediator_epoch > self.epoch)


class FollowsOwnJournal(Robot):
    """It never follows a mediator with another journal."""

    def may_follow(self, message: Any, now: float) -> bool:
        return super().may_follow(message, now) and message.journal == self.journal


class KeepsAllLevels(Robot):
    """It keeps its levels, whatever process of the robot another mediator means."""

    def contradicts(self, message: Any) -> bool:
        return False


class BelievesWhoStandsBy(Robot):
    """It takes an epoch from whoever says one, and ignores smaller ones."""

    most = 0

    def is_plausible(self, message: Any, now: float) -> bool:
        plausible = super().is_plausible(message, now)
        if plausible:
            self.most = max(self.most, message.mediator_epoch)
        return plausible and message.mediator_epoch == self.most


class AlwaysHears(Robot):
    """It says that it hears the mediator when that is silent."""

    def report(self, now: float) -> Any:
        report = super().report(now)
        report.mediator_heard = True
        return report
