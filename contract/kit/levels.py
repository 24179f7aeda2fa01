"""Levels of the protocol arrays, from the robot's side: what the mediator may add, and what the robot sets."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

REQUESTED, GRANTED, ENTERED, RELEASED = 1, 2, 3, 4
RETURNED = (1, 3)
"""Path and progress of a grant that was given back."""


@dataclass
class Claim:
    """Protocol 1 of one area, or its revocation."""

    run: int = 0
    path: int = 0
    progress: int = 0
    fence: int = 0
    after_abort: bool = False
    # Had at a registration, or had or asked for where the robot was thought to be: never entered, only given back.
    inherited: bool = False

    @classmethod
    def inherit(cls, entry: Any) -> Claim:
        """The level of a message, as it is."""
        level = entry.level
        claim = cls(level.run, level.path, level.progress, entry.fence, level.after_abort)
        claim.inherited = claim.held
        return claim

    @property
    def held(self) -> bool:
        """Granted, and neither released nor returned nor taken away."""
        return self.path == 0 and self.progress in (GRANTED, ENTERED)

    def is_over(self) -> bool:
        """The last flag of an area's run is set: its reader is to empty the array."""
        return self.progress == RELEASED or (self.path, self.progress) == RETURNED

    def learn(self, entry: Any, mine: int, strict: bool = False) -> bool:
        """Takes in the mediator's level, which may add its flag number `mine`, or begin another run; of an area where this process is bound by
        nothing it may be any level of a later run, unless that is `strict`. False: it cannot be."""
        level = entry.level
        if level.run < self.run or level.run == self.run and level.progress <= self.progress:
            return True
        if level.run > self.run:
            # Emptied after its last flag, or given up, or forgotten here.
            unbound = self.progress <= REQUESTED or self.is_over() if mine == GRANTED else self.progress != 1
            begins = level.progress == 0 if mine == GRANTED else level.progress <= mine
            if not (begins and level.after_abort) and not (unbound and (begins or mine == GRANTED and not strict)):
                return False
        elif self.progress != mine - 1 or level.progress != mine:
            return False
        taken_over = level.run > self.run
        self.run, self.path, self.progress, self.after_abort = level.run, level.path, level.progress, level.after_abort
        self.inherited = self.held if taken_over and mine == GRANTED else self.inherited
        self.fence = entry.fence if level.progress >= mine else 0
        return True

    def say(self, area: str, entries: Any) -> None:
        """Adds the level to a report."""
        entry = entries.add(area=area, fence=self.fence)
        entry.level.run, entry.level.path, entry.level.progress = self.run, self.path, self.progress
        entry.level.after_abort = self.after_abort


class Coordination:
    """Protocol 2: the discrete control of the robot by one coordination."""

    def __init__(self, control: Any) -> None:
        self.control = control
        self.number = control.coordination
        self.path, self.progress = control.level.path, control.level.progress
        # Of the orders that were carried out, how many flags were set.
        self.ordered = 0
        self._fired = False

    def flags(self, path: int) -> list[Any]:
        """The flags of a path, in their order."""
        order = self.control.paths[path].flags if self.control.paths else range(len(self.control.flags))
        return [self.control.flags[at] for at in order]

    @property
    def acquired(self) -> bool:
        """The robot's machine triggers nothing by itself."""
        return 1 <= self.progress < len(self.flags(self.path))

    def learn(self, control: Any) -> bool:
        """Takes in the mediator's level, which may add its own flags. False: it cannot be."""
        path, progress = control.level.path, control.level.progress
        if progress <= self.progress:
            return True
        if path >= max(1, len(self.control.paths)) or progress > len(self.flags(path)):
            return False
        mine, theirs = self.flags(self.path), self.flags(path)
        if mine[:self.progress] != theirs[:self.progress] or not all(flag.by_mediator for flag in theirs[self.progress:progress]):
            return False
        self.path, self.progress, self._fired = path, progress, False
        return True

    def next_order(self) -> Any | None:
        """The instruction of the newest flag of the mediator, once."""
        flags = self.flags(self.path)[:self.progress]
        if self.ordered >= self.progress or not flags:
            return None
        self.ordered = self.progress
        newest = [flag for flag in flags if flag.by_mediator]
        return newest[-1].instruction if newest and newest[-1].HasField("instruction") else None

    def release_order(self) -> Any | None:
        """What `release` orders, for a coordination that ends without it."""
        if self.progress >= len(self.flags(self.path)) - 1:
            return None
        flag = self.flags(self.path)[-2]
        return flag.instruction if flag.HasField("instruction") else None

    def output(self, name: str) -> None:
        """The machine has fired an output; it counts if the next flag waits for it."""
        flags = self.flags(self.path)
        if self.progress < len(flags) and flags[self.progress].on_output == name:
            self._fired = True

    def advance(self) -> bool:
        """Sets the robot's flags that are next. Returns whether one was."""
        before, flags = self.progress, self.flags(self.path)
        while self.progress < len(flags) and not flags[self.progress].by_mediator:
            if flags[self.progress].on_output and not self._fired:
                break
            self.progress, self._fired = self.progress + 1, False
        return self.progress != before
