"""Protocol 1 as robots are to keep it."""

from __future__ import annotations

import time

from .. import page
from ..checks import Failed
from ..hall import Hall, Said
from ..played_robot import Claim
from . import SUITE

GRANTED = "No part of the robot may be in an area before `granted`, nor newly reach into one without a lease (below)."
SETS = "It sets `entered` when its footprint reaches in, and `released` when no part of it is there any more."
FENCE = "Levels from `granted` on carry the fence of their grant, also those of `released` and `returned`, until the mediator has emptied the array"
YOURS = "A level may add only flags of its sender. One that claims yours is wrong: ignore it, and count it."
NEXT = "After the last flag of a run its reader empties the array: the next run begins with progress 0. Only then may the next first flag be set."


@SUITE.check("enters-only-granted", GRANTED)
def enters_only_granted(hall: Hall) -> None:
    """Without grants ahead the robot stays in the areas that it has, for 8 s before a border."""
    hall.ahead()
    before = hall.stands_in()
    hall.never(8.0, lambda said: not set(said.report.stands_in) <= before, f"no area but {sorted(before)}")


@SUITE.check("asks-where-it-stands", "A robot that registers asks first for the areas it stands in (`stands_in`).")
def asks_where_it_stands(hall: Hall) -> None:
    """Registered anew, by a mediator that has taken all from it, it asks for the areas that it stands in."""
    hall.ahead()
    with hall.lock:
        hall.grants, hall.session, hall.robot_sequence = (lambda area: False), hall.session + 1, 0
        hall.levels = {area: Claim(own.run + 1) for area, own in hall.levels.items()}
        hall.grant()
        hall.send()

    def asks(said: Said) -> bool:
        inside = [said.access(area) for area in said.report.stands_in]
        return hall.counts(said) and bool(inside) and all(claim is not None and claim.progress == 1 for claim in inside)

    hall.expect(hall.soon_s, asks, "a request for each area that it stands in")


@SUITE.check("drives-through", SETS, FENCE)
def drives_through(hall: Hall) -> None:
    """An area is entered when it is stood in and released when it is not, with the grant's fence all the way to the emptied array."""
    area = hall.ahead()
    hall.full = {area}
    hall.let_into(area)
    grant = hall.levels[area]
    begin = len(hall.said)
    hall.expect(hall.patience_s, lambda said: said.access(area) == grant.then(3), f"{area} entered, with fence {grant.fence}")
    hall.grants = lambda name: True
    hall.expect(hall.patience_s, lambda said: said.access(area) == grant.then(4), f"{area} released, with fence {grant.fence}")
    left_s = None
    for said in hall.said[begin:]:
        claim, stands = said.access(area), area in said.report.stands_in
        # It may need the area until its manoeuvre is over, which a report may say before that.
        late = claim is not None and claim.progress == 3 and not stands
        left_s = (left_s or said.at) if late else None
        if claim is not None and claim.progress == 4 and stands or left_s is not None and said.at > left_s + hall.soon_s:
            raise Failed(f"entered while stands_in names {area}, and released when not", f"{claim}, stands in {list(said.report.stands_in)}")
        if claim is not None and claim.progress == 2 and claim.fence != grant.fence:
            raise Failed(f"fence {grant.fence}", f"{claim}")


@SUITE.check("waits-for-emptied", NEXT)
def waits_for_emptied(hall: Hall) -> None:
    """A released area is not asked for again before the mediator has emptied its array."""
    area = hall.ahead()
    hall.full = {area}
    hall.let_into(area)
    hall.grants = lambda name: True
    run = hall.levels[area].run
    hall.expect(hall.patience_s, lambda said: said.access(area) is not None and said.access(area).progress == 4, f"{area} released")
    hall.never(3.0, lambda said: said.access(area) is not None and said.access(area).run != run, f"run {run} of {area} until it is emptied")


@SUITE.check("claimed-flag-ignored", YOURS)
def claimed_flag(hall: Hall) -> None:
    """A message that claims the robot's `entered` is ignored: the robot neither repeats it nor goes in."""
    area = hall.ahead()
    before, own = hall.stands_in(), hall.levels[area]
    with hall.lock:
        hall.levels[area] = Claim(own.run, 0, 3, hall.fences.get(area, 0) + 1)
        hall.send()
    hall.never(4.0, lambda said: area in said.report.stands_in and area not in before
               or said.access(area) is not None and said.access(area).progress >= 3, f"{area} asked for, neither entered nor stood in")
    with hall.lock:
        hall.levels[area] = own


@SUITE.check("old-run-ignored", "A level with a smaller run, or the same run and less progress on the same path, says nothing new.")
def old_run(hall: Hall) -> None:
    """A level of a smaller run or with less progress, in a new message, takes nothing from the robot and gives it nothing."""
    hall.ahead()
    inside = [area for area in hall.stands_in() if hall.levels.get(area, Claim()).held]
    if not inside:
        raise Failed("a grant of an area that the robot stands in", hall.found())
    area = inside[0]
    own = hall.levels[area]
    with hall.lock:
        hall.levels[area] = Claim(own.run, 0, 1, 0)
        hall.send()
    hall.never(hall.watch_s, lambda said: area in said.report.stands_in and (said.access(area) is None or not said.access(area).held),
               f"{area} entered, in which it stands")
    with hall.lock:
        hall.levels[area] = own


@SUITE.check("larger-run-taken-over", "where it has done no more than ask, or what it had is over, it takes over the level of a larger `run` as at a registration")
def larger_run(hall: Hall) -> None:
    """An area of which the mediator is in a later run is asked for in that run, and entered when it is granted."""
    area = hall.ahead()
    with hall.lock:
        run = hall.levels[area].run + 3
        hall.levels[area] = Claim(run)
        hall.send()
    hall.expect(hall.soon_s, lambda said: said.access(area) is not None and (said.access(area).run, said.access(area).progress) == (run, 1),
                f"{area} asked for in run {run}")
    hall.let_into(area)
    hall.expect(hall.patience_s, lambda said: area in said.report.stands_in, f"{area} entered")


@SUITE.check("given-up-inside", "It stops, and asks again, as for all areas in which it stands; whoever stands in an area comes first there.",
             "The mediator may give up a run: the next one then begins with `after_abort`. All that the robot had by that run is void.")
def given_up_inside(hall: Hall) -> None:
    """When a run is given up while the robot is inside it stops, and asks again in the next run."""
    ahead = hall.ahead()
    hall.let_into(ahead)
    hall.expect(hall.patience_s, lambda said: ahead in said.report.stands_in and said.access(ahead) is not None
                and said.access(ahead).progress == 3, f"{ahead} entered")
    with hall.lock:
        hall.grants = lambda area: False
        run = hall.levels[ahead].run + 1
        hall.levels[ahead] = Claim(run)
        message = hall.message()
        hall.sequence += 1
        for entry in message.access:
            entry.level.after_abort = entry.area == ahead
        hall.put(message)
        hall.speaks = False
    hall.expect(hall.soon_s, lambda said: said.access(ahead) is not None and (said.access(ahead).run, said.access(ahead).progress) == (run, 1),
                f"{ahead} asked for in run {run}")
    time.sleep(1.0)
    with hall.lock:
        hall.speaks = True
        hall.levels[ahead] = Claim(run, 0, 1)
    pose = hall.said[-1].report.pose
    hall.never(2.0, lambda said: abs(said.report.pose.x_m - pose.x_m) + abs(said.report.pose.y_m - pose.y_m) > 0.1, "a robot that stands")


@SUITE.check("repeats-levels", "Everything that is still so, in every report")
def repeats_levels(hall: Hall) -> None:
    """Levels of all areas that it asks for or has are in every report."""
    area = hall.ahead()
    names = {area, *(name for name, own in hall.levels.items() if own.held)}

    def lacks(said: Said) -> bool:
        return any(said.access(name) is None for name in names)

    hall.never(2 * page.SILENT_S, lacks, f"levels of {sorted(names)} in every report")
