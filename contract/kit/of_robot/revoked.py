"""Grants that are asked back."""

from __future__ import annotations

import time

from .. import page
from ..checks import Failed
from ..hall import Hall
from ..played_robot import Claim
from . import SUITE

REVOKE = ("`revoke` (mediator), then path 0 `yielded` (robot, along with `returned` above, or with `released` where it has left the area and "
          "kept it) or path 1 `kept` (robot: it is in the area, or can no longer stop before it).")
ALREADY = "One that has given that grant back already answers `yielded`."


def answered(hall: Hall, area: str, answer: Claim, why: str) -> None:
    """That a revocation is answered so."""
    hall.expect(hall.soon_s, lambda said: said.revocation(area) is not None and (
        said.revocation(area).run, said.revocation(area).path, said.revocation(area).progress) == (answer.run, answer.path, answer.progress),
        f"`{'kept' if answer.path else 'yielded'}` for {area}, level {answer.run}/{answer.path}/{answer.progress}: {why}")


def ask_back(hall: Hall, area: str, fence: int) -> Claim:
    """Asks for a grant back, in the next run of the array. Returns the level of the question."""
    with hall.lock:
        hall.revocations[area] = Claim(hall.next_revocation.get(area, 0), 0, 1, fence)
        hall.send()
        return hall.revocations[area]


@SUITE.check("yields-before-entering", REVOKE)
def yields(hall: Hall) -> None:
    """A grant that was not entered is given back with `returned` when it is asked back, and not entered."""
    area = hall.ahead()
    hall.stands_still()
    hall.echoes = False
    time.sleep(page.LEASE_S + 2 * page.LEVEL_S)
    # Without a lease it stands before the border, with the grant.
    hall.full = {area}
    hall.let_into(area)
    grant = hall.levels[area]
    hall.expect(hall.soon_s, lambda said: said.access(area) == grant, f"the grant {grant} repeated")
    hall.grants = lambda name: False
    asked = ask_back(hall, area, grant.fence)
    answered(hall, area, Claim(asked.run, 0, 2), "it can stop before the border")
    hall.expect(hall.soon_s, lambda said: said.access(area) == grant.then(3, path=1), f"{area} returned with fence {grant.fence}")
    before = hall.stands_in()
    hall.echoes, hall.full = True, set()
    hall.never(3.0, lambda said: area in said.report.stands_in and area not in before, f"{area} not entered after `yielded`")


@SUITE.check("keeps-inside", REVOKE)
def keeps_inside(hall: Hall) -> None:
    """A grant of an area that the robot stands in is kept when it is asked back, and the robot stays entered."""
    area = hall.ahead()
    hall.let_into(area)
    hall.expect(hall.patience_s, lambda said: said.access(area) is not None and said.access(area).progress == 3, f"{area} entered")
    hall.grants = lambda name: False
    grant = hall.levels[area]
    asked = ask_back(hall, area, grant.fence)
    answered(hall, area, Claim(asked.run, 1, 2), "it stands in it")
    said = hall.said[-1]
    if area in said.report.stands_in and (said.access(area) is None or not said.access(area).held):
        raise Failed(f"{area} still held", hall.found())


@SUITE.check("larger-revocation-answered", "a revocation of a larger `run` it answers as any other, unless one of a smaller `run` is not answered yet")
def larger_revocation(hall: Hall) -> None:
    """A revocation is answered although the robot has heard nothing of those before it."""
    area = hall.ahead()
    hall.let_into(area)
    hall.expect(hall.patience_s, lambda said: said.access(area) is not None and said.access(area).progress == 3, f"{area} entered")
    hall.grants = lambda name: False
    hall.next_revocation[area] = hall.next_revocation.get(area, 0) + 3
    asked = ask_back(hall, area, hall.levels[area].fence)
    answered(hall, area, Claim(asked.run, 1, 2), "it stands in it")


@SUITE.check("yields-what-it-gave-back", ALREADY)
def gave_back(hall: Hall) -> None:
    """A revocation of an older grant is answered with `yielded`, and costs the robot nothing that it has."""
    area = hall.ahead()
    hall.let_into(area)
    hall.expect(hall.patience_s, lambda said: said.access(area) is not None and said.access(area).progress == 3, f"{area} entered")
    hall.grants = lambda name: False
    grant = hall.levels[area]
    asked = ask_back(hall, area, grant.fence - 1)
    answered(hall, area, Claim(asked.run, 0, 2), f"it has fence {grant.fence}, and fence {grant.fence - 1} was asked back")
    hall.never(hall.watch_s, lambda said: area in said.report.stands_in and said.access(area) != grant.then(3), f"{area} kept: {grant.then(3)}")


@SUITE.check("answers-repeated", "Everything that is still so, in every report", REVOKE)
def answers_repeated(hall: Hall) -> None:
    """An answer that the mediator has not acknowledged is in every report."""
    hall.ahead()
    hall.echoes = False
    inside = [name for name in hall.stands_in() if hall.levels.get(name, Claim()).held]
    if not inside:
        raise Failed("a grant of an area that the robot stands in", hall.found())
    asked = ask_back(hall, inside[0], hall.levels[inside[0]].fence)
    answered(hall, inside[0], Claim(asked.run, 1, 2), "it stands in it")
    hall.never(page.SILENT_S, lambda said: said.revocation(inside[0]) is None or said.revocation(inside[0]).progress != 2,
               "the answer in every report")
