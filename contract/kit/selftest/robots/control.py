"""Robots that a coordination takes in, and that do not play along."""

from __future__ import annotations

from typing import Any

from ...robot import Robot


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


class KeepsOldCoordination(Robot):
    """It goes back to a coordination with a smaller number."""

    def learn_control(self, message: Any, registers: bool) -> None:
        if self.coordination is not None and message.HasField("control") and message.control.coordination != self.coordination.number:
            self.coordination = None
        super().learn_control(message, registers)


class NeverAnswers(Robot):
    """It does not answer `acquire`."""

    def learn_control(self, message: Any, registers: bool) -> None:
        message.ClearField("control")
        super().learn_control(message, registers)


class IgnoresAreasOfOrders(Robot):
    """It does not look at the areas of an order."""

    def ordered_areas(self) -> list[str]:
        return []


class NeverReleased(Robot):
    """It does not answer `release`."""

    def carry_out_orders(self) -> None:
        coordination = self.coordination
        if coordination is None or coordination.progress < len(coordination.flags(coordination.path)) - 1:
            super().carry_out_orders()


class NeverFree(Robot):
    """It goes on with a coordination that is over."""

    def learn_control(self, message: Any, registers: bool) -> None:
        if message.HasField("control"):
            super().learn_control(message, registers)


class BelievesItsFlags(Robot):
    """It takes over whatever flags of a coordination a message says are set."""

    def learn_control(self, message: Any, registers: bool) -> None:
        super().learn_control(message, registers)
        if self.coordination is not None and message.HasField("control"):
            self.coordination.progress = max(self.coordination.progress, message.control.level.progress)
