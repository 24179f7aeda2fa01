"""Areas of robots that are silent, or stand where they should not; and grants that are asked back."""

from __future__ import annotations

import time
from typing import Callable

from .. import page
from ..checks import Failed
from ..fleet import Fleet, at_progress, found, holds
from ..played_robot import Claim, Heard, PlayedRobot
from . import SUITE

SILENT = ("A robot that the mediator has not heard for 1 s counts as silent, not as gone: its areas are blocked until it is back, or until an "
          "operator clears them.")
REVOKE = ("Revoking has its own array, which names by `fence` the grant that is asked back: `revoke` (mediator), then path 0 `yielded` "
          "(robot, along with `returned` above, or with `released` where it has left the area and kept it) or path 1 `kept` (robot: it is in "
          "the area, or can no longer stop before it).")
ASKED = ("It is asked when a coordination needs the area, of robots that have not entered it; and when somebody is in it who should not be, or "
         "an operator closes it, of all that are not in it.")
FIRST = "whoever stands in an area comes first there. Nobody else is let in meanwhile."


@SUITE.check("silence-blocks", SILENT, needs=["2 robots"])
def silence_blocks(fleet: Fleet) -> None:
    """What a silent robot stands in, and what it had not entered, goes to nobody, also after 5 s; when it is back it still has it."""
    first, second = fleet.robots[:2]
    inside, ahead = fleet.areas(2)
    fleet.obtain(first, inside)
    first.enter(inside)
    fleet.obtain(first, ahead)
    first.speaks = False
    time.sleep(page.SILENT_S)
    second.request(inside)
    second.request(ahead)
    fleet.never(second, page.ENTERS_NO_MORE_S + fleet.settings.margin_s, lambda heard: holds(inside)(heard) or holds(ahead)(heard),
                f"no grant of {inside} or {ahead}: silent {first.robot_id} has both")
    first.speaks = True
    sent = first.send()
    fleet.expect(first, fleet.soon_s, lambda heard: heard.message.robot_sequence >= sent and holds(inside)(heard) and holds(ahead)(heard),
                 f"{inside} and {ahead} are still those of {first.robot_id}, which is back")
    first.leave(inside)
    fleet.granted(second, inside)


@SUITE.check("place-of-silent", SILENT, "it grants an area to no more robots than its capacity, counting whoever stands in it.", needs=["2 robots"])
def place_of_silent(fleet: Fleet) -> None:
    """Where a silent robot stands without a grant is blocked as well."""
    first, second = fleet.robots[:2]
    area, = fleet.areas(1)
    first.stands_in = [area]
    sent = first.send()
    fleet.expect(first, fleet.soon_s, lambda heard: heard.message.robot_sequence >= sent, "the report to count")
    first.speaks = False
    time.sleep(page.SILENT_S)
    second.request(area)
    fleet.refused(second, area, f"silent {first.robot_id} stands in it", 2 * fleet.watch_s)
    # Before its next process stands elsewhere it says that it has left.
    first.speaks = True


@SUITE.check("stands-first", FIRST, needs=["2 robots"])
def stands_first(fleet: Fleet) -> None:
    """Who stands in an area without a grant keeps others out, although they asked before; and is granted it."""
    first, second = fleet.robots[:2]
    area, = fleet.areas(1)
    with first.lock:
        first.stands_in = [area]
        sent = first.send()
    fleet.expect(first, fleet.soon_s, lambda heard: heard.message.robot_sequence >= sent, "the report to count")
    second.request(area)
    fleet.refused(second, area, f"{first.robot_id} stands in it")
    fleet.obtain(first, area)


@SUITE.check("not-located-keeps", "and is not `located` until then.", SILENT, needs=["2 robots"])
def not_located_keeps(fleet: Fleet) -> None:
    """A robot that says that it is not located has left nothing, although its reports name no area."""
    first, second = fleet.robots[:2]
    area, = fleet.areas(1)
    with first.lock:
        first.stands_in = [area]
        sent = first.send()
    fleet.expect(first, fleet.soon_s, lambda heard: heard.message.robot_sequence >= sent, "the report to count")
    with first.lock:
        first.located, first.stands_in = False, []
        first.send()
    second.request(area)
    fleet.refused(second, area, f"{first.robot_id} was there, and does not know where it is")


def asked_back(area: str, claim: Claim) -> Callable[[Heard], bool]:
    """Whether a message asks for this grant back."""
    def judge(heard: Heard) -> bool:
        asked = heard.revocation(area)
        return asked is not None and asked.progress == 1 and asked.fence == claim.fence

    return judge


def intrusion(fleet: Fleet) -> tuple[str, PlayedRobot, PlayedRobot, Claim, Claim]:
    """A robot with a grant that it has not entered, another one in that area, and the mediator's revocation."""
    first, second = fleet.robots[:2]
    area, = fleet.areas(1)
    claim = fleet.obtain(first, area)
    with second.lock:
        second.stands_in = [area]
        second.request(area)
    heard = fleet.expect(first, fleet.soon_s, asked_back(area, claim),
                         f"a revocation of {area} with fence {claim.fence}, since {second.robot_id} is in it")
    asked = heard.revocation(area)
    assert asked is not None
    return area, first, second, claim, asked


@SUITE.check("revocation-yielded", REVOKE, ASKED, "Until it answers, the robot has the area", needs=["2 robots"])
def revocation_yielded(fleet: Fleet) -> None:
    """A revocation names the fence; until it is answered nobody else has the area; `yielded` with `returned` empties both arrays."""
    area, first, second, claim, asked = intrusion(fleet)
    fleet.refused(second, area, f"{first.robot_id} has not answered")
    with first.lock:
        first.revocations[area] = asked.then(2)
        first.give_back(area)
    fleet.expect(first, fleet.soon_s, at_progress(area, claim.run + 1, 0), f"{area} emptied")
    fleet.expect(first, fleet.soon_s, lambda heard: heard.revocation(area) is not None and heard.revocation(area).run > asked.run,
                 "the revocation's array emptied")
    fleet.granted(second, area)


@SUITE.check("revocation-of-what-is-left", REVOKE, ASKED, "One whose manoeuvre comes back to the area may keep it in between, entered.",
             needs=["2 robots"])
def revocation_of_what_is_left(fleet: Fleet) -> None:
    """Where somebody else is, what a robot has left and keeps is asked back as well; `yielded` with `released` empties both arrays."""
    first, second = fleet.robots[:2]
    area, = fleet.areas(1)
    claim = fleet.obtain(first, area)
    first.enter(area)
    fleet.expect(first, fleet.soon_s, at_progress(area, claim.run, 3), f"{area} entered")
    with first.lock:
        first.stands_in = []
        first.send()
    with second.lock:
        second.stands_in = [area]
        second.request(area)
    heard = fleet.expect(first, fleet.soon_s, asked_back(area, claim), f"a revocation of {area} with fence {claim.fence}")
    asked = heard.revocation(area)
    assert asked is not None
    with first.lock:
        first.revocations[area] = asked.then(2)
        first.leave(area)
    fleet.granted(second, area)


@SUITE.check("revocation-kept", REVOKE, ASKED, needs=["2 robots"])
def revocation_kept(fleet: Fleet) -> None:
    """After `kept` the robot still has the area, and nobody else gets it."""
    area, first, second, claim, asked = intrusion(fleet)
    with first.lock:
        first.stands_in = [area]
        first.claims[area] = claim.then(3)
        first.revocations[area] = asked.then(2, path=1)
        first.send()
    fleet.refused(second, area, f"{first.robot_id} keeps it")
    newest = first.newest
    if newest is None or not holds(area)(newest):
        raise Failed(f"{first.robot_id} still has {area}", found(first))


@SUITE.check("revocation-asked-again", "One that has answered `kept` and is not in the area a second later is asked again, in a new run",
             "| a grant that was kept and not entered is asked back again after | 1 s |", needs=["2 robots"])
def revocation_asked_again(fleet: Fleet) -> None:
    """Who has kept an area without entering it is asked again."""
    area, first, _, claim, asked = intrusion(fleet)
    with first.lock:
        first.revocations[area] = asked.then(2, path=1)
        first.send()

    def again(heard: Heard) -> bool:
        newest = heard.revocation(area)
        return asked_back(area, claim)(heard) and newest is not None and newest.run > asked.run

    fleet.expect(first, page.ASKED_AGAIN_S + fleet.soon_s, again, f"another revocation of {area} with fence {claim.fence}")


@SUITE.check("revocation-repeated", "Everything that is still so, in every report", "| a level is sent at least every | 200 ms |",
             needs=["2 robots"])
def revocation_repeated(fleet: Fleet) -> None:
    """A revocation that is not answered is asked again in every message."""
    area, first, _, claim, _ = intrusion(fleet)
    begin = len(first.messages)
    time.sleep(page.SILENT_S)
    if not all(asked_back(area, claim)(heard) for heard in first.messages[begin:]) or len(first.messages) == begin:
        raise Failed(f"the revocation of {area} in every message until it is answered", found(first))
