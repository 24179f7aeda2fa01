"""Which mediator a robot follows, what of its messages counts, and the lease that they give."""

from __future__ import annotations

import math
import random
import sys
from typing import Any

from . import page, wire
from .floor import HASH_OF_NOTHING, floor_hash

LAST_NUMBER = 1 << 62
EPOCH_STEP = SEQUENCE_STEP = 1 << 20


class Follower:
    """A robot's identity and its registration. What is in a message that counts is for `learn_levels` and `learn_control`."""

    def __init__(self, robot_id: str) -> None:
        self.robot_id = robot_id
        self.boot_epoch = random.getrandbits(64) or 1
        self.floor: list[Any] = []
        self.floor_hash = HASH_OF_NOTHING
        self.epoch = self.heard_sequence = self.session = self.instance = self.journal = 0
        # Mediators that were followed before, and epoch and sequence of what was heard of them last.
        self.before: dict[int, tuple[int, int]] = {}
        self.sequence = 0
        self.heard_at = -math.inf
        self.stands_by = self.identity_taken = False
        self.refusal = ""
        # When reports were sent that may still give a lease, and when the newest was sent that the mediator says it has.
        self.sent: dict[int, float] = {}
        self.lease_from = -math.inf
        self.take_up: Any = None
        self.other_since = self.other_at = -math.inf
        # When another mediator was heard last that may grant something; and until when this process listens whether there is one.
        self.other_grants_at = self.listens_until = -math.inf
        self.wrong = 0
        # Something is to be reported at once.
        self.news = False

    def forget(self) -> None:
        """It has nothing."""
        raise NotImplementedError

    def learn_levels(self, message: Any, registers: bool) -> None:
        """Takes in levels of protocol 1."""
        raise NotImplementedError

    def learn_control(self, message: Any, registers: bool) -> None:
        """Takes in protocol 2."""
        raise NotImplementedError

    def contradicts(self, message: Any) -> bool:
        """Whether the levels of a mediator that is followed anew are of a process before this one."""
        raise NotImplementedError

    def receive(self, data: bytes, now: float) -> None:
        """Takes in a message, however late, repeated, wrong or long it is."""
        message: Any = wire.decode(wire.MediatorReport, data)
        if message is None or not self.is_for_me(message) or not self.is_plausible(message, now):
            return
        if message.version.major != page.VERSION[0]:
            return
        other = self.instance != 0 and message.instance != self.instance
        if message.stands_by and message.session == 0:
            # It says nothing else: its epoch does not count.
            self.refusal = self.refusal if self.session else message.refusal
            return
        if other and not self.may_follow(message, now):
            self.note_other(message, now)
            return
        registered_before = self.session != 0
        if other:
            self.before = dict([*self.before.items(), (self.instance, (self.epoch, self.heard_sequence))][-8:])
        self.epoch, self.heard_sequence, self.heard_at = message.mediator_epoch, message.sequence, now
        self.instance, self.journal, self.stands_by = message.instance, message.journal, message.stands_by
        self.refusal, self.identity_taken = message.refusal, message.identity_taken
        if other:
            self.lease_from = -math.inf
        same_floor = self.same_floor(message)
        if message.session == 0 or not same_floor:
            self.session, self.news = 0, self.news or self.session != 0
            if message.identity_taken:
                # Another process has whatever this one had.
                self.forget()
            return
        self.renew_lease(message.robot_sequence)
        # Two mediators of one epoch count their sessions alike.
        another = self.session != message.session or other
        registers = another and not (other and registered_before and not self.contradicts(message))
        self.news |= another
        self.session = message.session
        if registers:
            self.listens_until = now + page.LISTENS_FIRST_S
            self.forget()
            self.take_up = message.take_up if message.HasField("take_up") else None
        self.learn_levels(message, registers)
        self.learn_control(message, registers)

    def is_for_me(self, message: Any) -> bool:
        """For this robot and boot, and news from whom it is."""
        followed = self.instance == 0 or message.instance == self.instance
        newest = (self.epoch, self.heard_sequence) if followed else self.before.get(message.instance, (0, -1))
        old = (message.mediator_epoch, message.sequence) <= newest
        return message.robot_id == self.robot_id and message.boot_epoch == self.boot_epoch and not old

    def is_plausible(self, message: Any, now: float) -> bool:
        """Not what no mediator says."""
        takes_over = self.hears(now) and message.journal == self.journal
        followed = self.instance != 0 and message.instance == self.instance or takes_over
        most = min(LAST_NUMBER, self.epoch + EPOCH_STEP) if followed else LAST_NUMBER
        named = message.instance != 0 and message.journal != 0
        plausible = named and message.mediator_epoch <= most and message.sequence <= LAST_NUMBER
        self.wrong += not plausible
        return plausible

    def may_follow(self, message: Any, now: float) -> bool:
        """Whether another mediator takes over from the one that is followed."""
        silent = now > self.heard_at + page.SILENT_S
        if message.stands_by:
            return False
        same_journal = message.journal == self.journal
        if self.session == 0:
            # Not a late message of one that has ended, which leaves out what this robot has told it and has forgotten since.
            ended = same_journal and message.mediator_epoch < self.epoch
            return not ended and (message.session != 0 or silent)
        if self.stands_by and message.mediator_epoch >= self.epoch:
            return True
        if message.session == 0 and not same_journal:
            # It refuses, and knows nothing of what this robot has.
            return False
        return message.mediator_epoch > self.epoch and (same_journal or silent)

    def note_other(self, message: Any, now: float) -> None:
        """Tells people when another mediator speaks for long; and while it may grant something, this robot enters nothing."""
        ended = message.journal == self.journal and message.mediator_epoch < self.epoch
        if not message.stands_by and not ended:
            self.other_grants_at = now
        if now > self.other_at + page.SILENT_S:
            self.other_since = now
        if now > self.other_since + page.DOUBLED_S >= self.other_at:
            print("another mediator speaks to this robot as well", file=sys.stderr)
        self.other_at = now

    def same_floor(self, message: Any) -> bool:
        """Whether the mediator's floor is this robot's; one without a floor takes the mediator's."""
        if not self.floor and message.floor and floor_hash(message.floor) == message.floor_hash:
            self.floor, self.floor_hash, self.news = list(message.floor), message.floor_hash, True
        return message.floor_hash == self.floor_hash

    def renew_lease(self, echoed: int) -> None:
        """The mediator has this report: the lease runs from when it was sent."""
        if echoed in self.sent:
            self.lease_from = self.sent[echoed]
            self.sent = {sequence: at for sequence, at in self.sent.items() if sequence > echoed}
        if self.sequence < echoed <= max(self.sequence + SEQUENCE_STEP, LAST_NUMBER // 2):
            # Somebody has spoken in its name: the next report is to count.
            self.sequence = echoed

    def has_lease(self, now: float) -> bool:
        """Whether it may newly reach into what it was granted: by its lease, and since no other mediator is heard that grants."""
        alone = now >= self.listens_until and now > self.other_grants_at + page.SILENT_S
        return alone and self.session != 0 and now < self.lease_from + page.LEASE_S and now <= self.heard_at + page.SILENT_S

    def hears(self, now: float) -> bool:
        """Whether the mediator that it follows is heard."""
        return self.session != 0 and now <= self.heard_at + page.SILENT_S and not self.stands_by
