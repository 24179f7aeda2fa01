"""The example robot, each time with one mistake that an implementation may well make: `python -m kit.selftest.wrong_robots NAME ...`.

`WRONG` says which checks must find it.
"""

from __future__ import annotations

import math
import sys
from typing import Any

from .. import page, wire
from ..body import centre
from ..levels import ENTERED, Claim
from ..robot import Robot, run


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


class LeaseOfAnyNumber(Robot):
    """It takes any number that is not smaller than its own for an echo."""

    def renew_lease(self, echoed: int) -> None:
        super().renew_lease(min(echoed, self.sequence))


class BelievesOldMessages(Robot):
    """It takes in messages in the order in which they come."""

    def is_for_me(self, message: Any) -> bool:
        return message.robot_id == self.robot_id and message.boot_epoch == self.boot_epoch

    def receive(self, data: bytes, now: float) -> None:
        message: Any = wire.decode(wire.MediatorReport, data)
        super().receive(data, now)
        for entry in message.access if message is not None else ():
            # It overwrites what it knows by what it hears.
            if entry.area in self.claims and entry.level.progress == 2:
                self.claims[entry.area].progress, self.claims[entry.area].fence = 2, entry.fence


class BelievesOtherBoots(Robot):
    """It does not look for which of its boots a message is."""

    def is_for_me(self, message: Any) -> bool:
        message.boot_epoch = self.boot_epoch
        return super().is_for_me(message)


class BelievesNonsense(Robot):
    """It believes every number."""

    def is_plausible(self, message: Any) -> bool:
        return True


class FollowsAnybody(Robot):
    """It follows whoever speaks."""

    def may_follow(self, message: Any, now: float) -> bool:
        return True


class TakesLateOffers(Robot):
    """It takes whatever session it is offered when it has none."""

    def may_follow(self, message: Any, now: float) -> bool:
        return self.session == 0 and message.session != 0 or super().may_follow(message, now)


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


class ForgetsSession(Robot):
    """It repeats one number of the two."""

    def report(self, now: float) -> Any:
        report = super().report(now)
        report.session = 0
        return report


class CountsByTwo(Robot):
    """Its numbers grow by two."""

    def report(self, now: float) -> Any:
        self.sequence += 1
        return super().report(now)


class ConstantBoot(Robot):
    """It has the same boot epoch each time."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.boot_epoch = 42


class BelievesTakeUp(Robot):
    """It takes where it was heard last for where it is."""

    def receive(self, data: bytes, now: float) -> None:
        super().receive(data, now)
        if self.take_up is not None:
            self.body.x_m, self.body.y_m = self.take_up.pose.x_m, self.take_up.pose.y_m
            self.located, self.take_up = True, None


class KeepsInherited(Robot):
    """It goes on with the grants of the process before."""

    def learn_levels(self, message: Any, registers: bool) -> None:
        super().learn_levels(message, registers)
        for claim in self.claims.values():
            claim.inherited = False

    def set_flags(self, wanted: list[str], committed: list[str]) -> None:
        super().set_flags(wanted + list(self.claims), committed)


class IgnoresIdentityTaken(Robot):
    """It keeps its areas when another process speaks for it."""

    def forget(self) -> None:
        if self.session != 0:
            super().forget()


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


class NoFence(Robot):
    """It leaves out the fence when it releases."""

    def report(self, now: float) -> Any:
        report = super().report(now)
        for entry in report.access:
            if entry.level.progress > ENTERED:
                entry.fence = 0
        return report


class AsksTooEarly(Robot):
    """It begins the next run of an array by itself."""

    def request(self, wanted: list[str]) -> None:
        for area, claim in self.claims.items():
            if claim.is_over():
                self.claims[area] = Claim(claim.run + 1)
        super().request(wanted)


class DrivesOnWhenGivenUp(Robot):
    """It takes no notice of a run that is given up."""

    def may_move(self) -> bool:
        return self.located and bool(self.floor)


class AsksWhileAcquired(Robot):
    """It asks for areas on its way although a coordination has taken it in."""

    def wanted(self, ahead: list[tuple[str, float]]) -> list[str]:
        return [area for area, _ in ahead]


class FlagsWithoutOutput(Robot):
    """It sets its flags without waiting for the machine."""

    def carry_out_orders(self) -> None:
        super().carry_out_orders()
        if self.coordination is not None and self.session:
            self.coordination._fired = True
            self.coordination.advance()


class LooksLate(Robot):
    """It names an area when its middle is inside."""

    def step(self, now: float, seconds: float) -> None:
        super().step(now, seconds)
        x, y = self.body.x_m, self.body.y_m
        self.stands_in = [area.id for area in self.floor if area.id in self.stands_in and math.dist((x, y), centre(area)) < 0.5]


class TakesOtherFloors(Robot):
    """It follows a mediator that knows another floor."""

    def same_floor(self, message: Any) -> bool:
        super().same_floor(message)
        return True


class RegistersAnyVersion(Robot):
    """It does not look at the version."""

    def receive(self, data: bytes, now: float) -> None:
        message: Any = wire.decode(wire.MediatorReport, data)
        if message is not None:
            message.version.major = page.VERSION[0]
            super().receive(message.SerializeToString(), now)


class KeepsOldCoordination(Robot):
    """It goes back to a coordination with a smaller number."""

    def learn_control(self, message: Any, registers: bool) -> None:
        if self.coordination is not None and message.HasField("control") and message.control.coordination != self.coordination.number:
            self.coordination = None
        super().learn_control(message, registers)


WRONG: dict[str, tuple[type[Robot], list[str]]] = {
    "enters-ungranted": (EntersUngranted, ["enters-only-granted"]),
    "no-lease": (NoLease, ["lease-kept", "lease-from-sending"]),
    "lease-from-hearing": (LeaseFromHearing, ["lease-from-sending"]),
    "lease-of-any-number": (LeaseOfAnyNumber, ["lease-of-unknown-number"]),
    "believes-old-messages": (BelievesOldMessages, ["old-message-ignored"]),
    "believes-other-boots": (BelievesOtherBoots, ["other-boot-ignored"]),
    "believes-nonsense": (BelievesNonsense, ["nonsense-numbers"]),
    "follows-anybody": (FollowsAnybody, ["other-mediator-ignored", "same-epoch-never"]),
    "takes-late-offers": (TakesLateOffers, ["late-offer-ignored"]),
    "follows-smaller-epochs": (FollowsSmallerEpochs, ["same-epoch-never"]),
    "never-follows": (NeverFollows, ["restart-followed"]),
    "forgets-on-restart": (ForgetsOnRestart, ["restart-followed"]),
    "forgets-session": (ForgetsSession, ["repeats-both"]),
    "counts-by-two": (CountsByTwo, ["sequence-by-one"]),
    "constant-boot": (ConstantBoot, ["first-reports"]),
    "believes-take-up": (BelievesTakeUp, ["take-up-not-believed"]),
    "keeps-inherited": (KeepsInherited, ["inherited-given-back"]),
    "ignores-identity-taken": (IgnoresIdentityTaken, ["identity-taken"]),
    "never-yields": (NeverYields, ["yields-before-entering"]),
    "yields-inside": (YieldsInside, ["keeps-inside"]),
    "yields-any-fence": (YieldsAnyFence, ["yields-what-it-gave-back"]),
    "no-fence": (NoFence, ["drives-through"]),
    "asks-too-early": (AsksTooEarly, ["waits-for-emptied"]),
    "drives-on-when-given-up": (DrivesOnWhenGivenUp, ["given-up-inside"]),
    "asks-while-acquired": (AsksWhileAcquired, ["acquired-asks-for-nothing"]),
    "flags-without-output": (FlagsWithoutOutput, ["waits-for-output"]),
    "looks-late": (LooksLate, ["names-before-border"]),
    "takes-other-floors": (TakesOtherFloors, ["refuses-other-floor"]),
    "registers-any-version": (RegistersAnyVersion, ["other-version-ignored"]),
    "keeps-old-coordination": (KeepsOldCoordination, ["larger-coordination"]),
}

if __name__ == "__main__":
    name, *rest = sys.argv[1:]
    run(Robot if name == "right" else WRONG[name][0], rest)
