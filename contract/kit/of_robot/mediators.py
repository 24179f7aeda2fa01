"""Which mediator a robot follows."""

from __future__ import annotations

import random
import time
from typing import Any

from .. import page
from ..checks import Failed
from ..hall import Hall
from ..played_robot import Claim
from . import SUITE

FOLLOWS = ("It follows another one with a larger `mediator_epoch`, as after a restart, at once if that has the same `journal`, else when its "
           "own has been silent for 1 s; and never one with the same or a smaller epoch: that knows nothing of it.")
PAST = "A message of a smaller `mediator_epoch`, or for another `boot_epoch`, is from the past: ignore it."
BEFORE = ("But where a level that comes with that `session` cannot follow its own, the other has heard of a process before this one alone, and the "
          "robot takes its levels over as at a first registration.")
KEEPS = "It keeps all levels, and takes over the `session`."
REFUSES = ("Nor does one with another `journal` that refuses it: what it has been registered for it keeps until another mediator offers a "
           "`session`.")
NONSENSE = ("Ignore, and count, what no mediator says: an `instance` or `journal` of 0, an epoch or `sequence` above 2^62, or from the instance "
            "that is followed, and while it is heard from another one with its `journal`, an epoch more than 2^20 above the last.")
NEWEST = "Within one epoch of the sender, the message with the largest `sequence` is the newest; ignore older ones."


def other_mediator(hall: Hall, epoch: int, journal: int | None = None, **changed: Any) -> Any:
    """A message of another mediator, which knows nothing of areas and offers a session."""
    instance = random.getrandbits(64) | 1
    drawn = random.getrandbits(64) | 1 if journal is None else journal
    return hall.message(mediator_epoch=epoch, instance=instance, journal=drawn, sequence=1, session=hall.session + 100, access=[], **changed)


def not_followed(hall: Hall, message: Any, why: str, repeats: int = 5) -> None:
    """That the robot stays with the mediator that it follows while another one speaks."""
    begin = len(hall.said)
    for _ in range(repeats):
        message.sequence += 1
        hall.put(message)
        time.sleep(0.1)
    time.sleep(page.SILENT_S)
    # It may have gone there and back.
    for said in hall.said[begin:]:
        followed = (said.report.mediator_instance, said.report.mediator_epoch)
        if followed == (message.instance, message.mediator_epoch) or followed[1] > hall.epoch:
            raise Failed(f"the mediator that it follows, epoch {hall.epoch}: {why}", f"a report with epoch {followed[1]}, instance {followed[0]}")
    if len(hall.said) == begin:
        raise Failed("reports all the while", "none")


@SUITE.check("smaller-epoch-ignored", PAST)
def smaller_epoch(hall: Hall) -> None:
    """A message of an earlier start of the mediator changes nothing."""
    hall.start_mediator(epochs=5)
    hall.expect(hall.soon_s, hall.counts, "registration with the larger epoch")
    late = hall.message(mediator_epoch=hall.epoch - 2, sequence=10**6, session=hall.session + 50)
    not_followed(hall, late, "a smaller epoch is from the past")


@SUITE.check("other-mediator-ignored", "ignores any other while that one is heard", FOLLOWS)
def other_ignored(hall: Hall) -> None:
    """Another mediator with a larger epoch and another journal is ignored while the own one is heard."""
    not_followed(hall, other_mediator(hall, hall.epoch + 10), "it is heard, and the other has another journal", repeats=15)


@SUITE.check("late-offer-ignored", "but none with the `journal` that it heard of last and a smaller `mediator_epoch`: that is a late message of one "
             "that has ended.")
def late_offer(hall: Hall) -> None:
    """A robot that was refused is not taken in by a late message of the mediator before, but by the next offer of the present one."""
    with hall.lock:
        late = other_mediator(hall, hall.epoch, journal=hall.journal)
        hall.registers = False
        hall.start_mediator()
        hall.send()
    hall.expect(hall.soon_s, lambda said: (said.report.session, said.report.mediator_epoch) == (0, hall.epoch), "session 0, since it is refused")
    for _ in range(5):
        late.sequence += 1
        hall.put(late)
    hall.never(hall.watch_s, lambda said: said.report.session != 0 or said.report.mediator_epoch != hall.epoch,
               f"session 0 and epoch {hall.epoch}: the mediator of epoch {late.mediator_epoch} has ended")
    hall.registers = True
    hall.expect(hall.soon_s, hall.counts, f"registration with the mediator of epoch {hall.epoch}")


@SUITE.check("same-epoch-never", FOLLOWS)
def same_epoch(hall: Hall) -> None:
    """A silent mediator is not exchanged for one with the same or a smaller epoch."""
    hall.start_mediator(epochs=5)
    hall.expect(hall.soon_s, hall.counts, "registration")
    hall.speaks = False
    time.sleep(page.SILENT_S + page.LEVEL_S)
    for epoch in (hall.epoch, hall.epoch - 1):
        not_followed(hall, other_mediator(hall, epoch), f"epoch {epoch} is not larger than {hall.epoch}")
    hall.speaks = True
    hall.expect(hall.soon_s, hall.counts, "the mediator that it followed, when it is back")


@SUITE.check("other-refusal-ignored", REFUSES)
def other_refusal(hall: Hall) -> None:
    """A robot whose mediator is silent keeps its registration when another one, with another journal, refuses it."""
    hall.speaks = False
    time.sleep(page.SILENT_S + page.LEVEL_S)
    refuses = other_mediator(hall, hall.epoch + 10, refusal="no such robot")
    refuses.session = 0
    not_followed(hall, refuses, "the other one refuses it")
    hall.speaks = True
    hall.expect(hall.soon_s, hall.counts, "the mediator that it followed, when it is back")


@SUITE.check("other-mediator-after-silence", FOLLOWS, KEEPS)
def after_silence(hall: Hall) -> None:
    """Another mediator with a larger epoch is followed once the own one is silent, and told of all levels."""
    hall.ahead()
    time.sleep(page.LEVEL_S)
    before = {name: claim for name, claim in hall.levels.items() if claim.held}
    hall.speaks = False
    time.sleep(page.SILENT_S + 2 * page.LEVEL_S)
    with hall.lock:
        hall.journal, hall.levels = random.getrandbits(64) | 1, {}
        hall.session += 1
        hall.start_mediator(epochs=3)
        hall.send()
    said = hall.expect(hall.soon_s, hall.counts, "reports under the epoch of the other mediator")
    for name, claim in before.items():
        if said.access(name) is None or not said.access(name).held or said.access(name).fence != claim.fence:
            raise Failed(f"{name} kept, with fence {claim.fence}", hall.found())


@SUITE.check("other-mediator-of-before", BEFORE)
def of_before(hall: Hall) -> None:
    """To another mediator, which has heard of a process before only, it gives back what that one had entered, but for where it stands."""
    ahead = hall.ahead()
    hall.speaks = False
    time.sleep(page.SILENT_S + 2 * page.LEVEL_S)
    with hall.lock:
        inside = next((area for area in hall.stands_in() if hall.levels.get(area, Claim()).held), None)
        if inside is None:
            raise Failed("a grant of an area that the robot stands in", hall.found())
        area = next(area.id for area in hall.floor if area.id != ahead and area.id not in hall.stands_in())
        run, held = (hall.levels.get(name, Claim()).run + 7 for name in (area, inside))
        hall.full.update((area, inside))
        hall.journal, hall.levels = random.getrandbits(64) | 1, {area: Claim(run, 0, 3, 50), inside: Claim(held, 0, 3, 51)}
        hall.session += 1
        hall.start_mediator(epochs=3)
        hall.send()

    def released(said: Any) -> bool:
        claim = said.access(area)
        return hall.counts(said) and claim is not None and (claim.run, claim.path, claim.progress) == (run, 0, 4)

    hall.expect(hall.soon_s, released, f"{area} released, run {run}")
    hall.expect(hall.soon_s, lambda said: said.access(inside) == Claim(held, 0, 3, 51), f"{inside} still entered, run {held}")


@SUITE.check("restart-followed", FOLLOWS, KEEPS, "go on with the levels that are there, under the new number.")
def restart_followed(hall: Hall) -> None:
    """A restarted mediator with the same journal is followed at once, and told of all levels, although it has forgotten them."""
    hall.ahead()
    time.sleep(page.LEVEL_S)
    before = {name: claim for name, claim in hall.levels.items() if claim.held}
    with hall.lock:
        hall.levels = {}
        hall.start_mediator()
        hall.send()
    said = hall.expect(hall.soon_s, hall.counts, "reports under the new epoch")
    for name, claim in before.items():
        if said.access(name) is None or not said.access(name).held or said.access(name).fence != claim.fence:
            raise Failed(f"{name} kept, with fence {claim.fence}", hall.found())


@SUITE.check("nonsense-numbers", NONSENSE)
def nonsense_numbers(hall: Hall) -> None:
    """Epochs and sequences above 2^62, a jump of the epoch by more than 2^20, and a mediator without a number of its own are ignored."""
    nameless = {"mediator_epoch": hall.epoch + 1, "sequence": 1}
    too_late = {"mediator_epoch": hall.epoch + 2**20 + 1}
    for changed in ({"mediator_epoch": 2**62 + 1}, {"sequence": 2**62 + 1}, too_late, {"instance": hall.instance ^ 2, **too_late},
                    {"instance": 0, **nameless}, {"journal": 0, **nameless}):
        with hall.lock:
            hall.put(hall.message(session=hall.session + 9, **changed))
        hall.never(3 * page.LEVEL_S, lambda said: said.report.session != hall.session or said.report.mediator_sequence > 2**61,
                   f"the registration as it was, after a message with {changed}")
        # It still hears.
        hall.send()
        sent = hall.sequence
        hall.expect(hall.soon_s, lambda said, sent=sent: said.report.mediator_sequence >= sent, f"mediator_sequence {sent}")


@SUITE.check("sequence-caught-up", "A robot that is told a number which it has not reached yet, within the same bounds, goes on from there.")
def sequence_caught_up(hall: Hall) -> None:
    """Somebody has sent reports in its name: its next ones have larger numbers."""
    ahead = 2**40
    hall.echoes, hall.robot_sequence = False, ahead
    hall.send()
    hall.expect(hall.soon_s, lambda said: said.report.sequence > ahead, f"reports with a sequence above {ahead}")
    hall.robot_sequence, hall.echoes = 0, True


@SUITE.check("larger-epoch-followed",
             "A larger `mediator_epoch` is a mediator that has restarted: go on with the levels that are there, under the new number.")
def larger_epoch(hall: Hall) -> None:
    """The same instance may take a larger epoch, which is repeated."""
    with hall.lock:
        hall.epoch, hall.sequence = hall.epoch + 1000, 0
        hall.send()
    hall.expect(hall.soon_s, hall.counts, f"epoch {hall.epoch}")


@SUITE.check("old-message-ignored", NEWEST)
def old_message(hall: Hall) -> None:
    """A late message with a smaller sequence changes nothing, whatever it grants."""
    area = hall.ahead()
    with hall.lock:
        late = hall.message()
        for _ in range(3):
            hall.send()
    time.sleep(page.LEVEL_S)
    for entry in late.access:
        if entry.area == area:
            entry.level.progress, entry.fence = 2, 10**6
    hall.put(late)
    hall.never(hall.watch_s, lambda said: said.access(area) is not None and said.access(area).progress != 1, f"{area} as asked for")


@SUITE.check("stands-by-said-counts-not", "A refusal with `stands_by` says nothing else: its epoch does not count.")
def stands_by(hall: Hall) -> None:
    """A refusal of a mediator that stands by, with a huge epoch, changes nothing."""
    message = other_mediator(hall, 2**60, stands_by=True, refusal="it stands by")
    message.session = 0
    not_followed(hall, message, "the other one stands by")
    hall.send()
    sent = hall.sequence
    hall.expect(hall.soon_s, lambda said: said.report.mediator_sequence >= sent, f"mediator_sequence {sent}: it follows whom it followed")


@SUITE.check("mediator-heard", "ignores any other while that one is heard (`mediator_heard`: within 1 s)")
def mediator_heard(hall: Hall) -> None:
    """`mediator_heard` is true while the mediator speaks, and false when it has been silent for 1 s."""
    hall.never(page.SILENT_S, lambda said: not said.report.mediator_heard, "mediator_heard")
    hall.speaks = False
    hall.expect(page.SILENT_S + hall.soon_s, lambda said: not said.report.mediator_heard, "mediator_heard false")
    hall.speaks = True
    hall.expect(hall.soon_s, lambda said: bool(said.report.mediator_heard), "mediator_heard again")
