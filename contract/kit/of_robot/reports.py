"""What a robot says of itself, whatever happens."""

from __future__ import annotations

import time
from collections.abc import Callable

from .. import page, wire
from ..checks import Failed
from ..floor import floor_hash
from ..hall import Hall
from . import SUITE

RATE = "| a level is sent at least every | 200 ms |"


def judge_rate(hall: Hall, times: Callable[[], list[float]], seconds: float = 3.0) -> None:
    """That messages come often enough, in one of three stretches: a busy machine holds robot and kit up now and then."""
    most, least = page.LEVEL_S + hall.margin_s / 2, int(seconds / page.LEVEL_S * 0.8)
    stretches = []
    for _ in range(3):
        begin = time.monotonic()
        time.sleep(seconds)
        inside = [begin, *(at for at in times() if begin < at < begin + seconds), begin + seconds]
        gap = max(later - earlier for earlier, later in zip(inside, inside[1:]))
        if len(inside) - 2 >= least and gap <= most:
            return
        stretches.append(f"{len(inside) - 2}, the largest gap {gap:.2f} s")
    raise Failed(f"at least {least} in {seconds:.0f} s, no gap above {most:.1f} s", "; ".join(stretches))


@SUITE.check("report-rate", RATE)
def report_rate(hall: Hall) -> None:
    """Reports come every 200 ms although nothing changes."""
    hall.ahead()
    judge_rate(hall, lambda: [said.at for said in hall.said])


@SUITE.check("state-rate", "| `PREFIX/robots/ID/state` | `RobotState` | robot, to everybody | on change, and at 5 Hz |")
def state_rate(hall: Hall) -> None:
    """The state for everybody comes at 5 Hz, with the identity and the boot of the reports."""
    judge_rate(hall, lambda: [at for at, _ in hall.states])
    state = hall.states[-1][1]
    if state is None or (state.robot_id, state.boot_epoch) != (hall.robot_id, hall.boot_epoch):
        raise Failed(f"robot_id {hall.robot_id}, boot_epoch {hall.boot_epoch}", f"{state}".replace("\n", " "))


@SUITE.check("alive-token", "| `PREFIX/robots/ID/alive` | liveliness token | robot | as long as its session lives |")
def alive_token(hall: Hall) -> None:
    """The liveliness token is there."""
    key = f"{hall.prefix}/robots/{hall.robot_id}/alive"
    if not hall.network.is_alive(key):
        raise Failed(f"a token {key}", "none")


@SUITE.check("sequence-by-one", "| `sequence` of a report, of a message to a robot | 1 | by one with each, in one epoch | 2^62 |",
             "| `boot_epoch`, `instance`, `journal` | drawn at random, not 0 | never | 2^64 - 1 |")
def sequence_by_one(hall: Hall) -> None:
    """The numbers of reports grow by one, and the boot epoch stays."""
    time.sleep(2 * page.SILENT_S)
    numbers = [said.report.sequence for said in hall.said]
    boots = {said.report.boot_epoch for said in hall.said}
    if any(later != earlier + 1 for earlier, later in zip(numbers, numbers[1:])) or len(boots) != 1 or 0 in boots:
        raise Failed("sequences that grow by one, and one boot_epoch that is not 0", f"sequences {numbers}, boot epochs {boots}")


@SUITE.check("version-said", "Reports carry a `Version`")
def version_said(hall: Hall) -> None:
    """Every report says the page's major version, the robot's id and the site."""
    said = hall.said[-1].report
    if said.version.major != page.VERSION[0] or said.robot_id != hall.robot_id or said.site != hall.site:
        raise Failed(f"version {page.VERSION[0]}, robot_id {hall.robot_id}, site {hall.site}",
                     f"version {said.version.major}, robot_id {said.robot_id}, site {said.site}")


@SUITE.check("floor-hash-said", "Every report and every message to a robot that is taken in carries `floor_hash`")
def floor_hash_said(hall: Hall) -> None:
    """Every report carries the hash of the floor."""
    expected = floor_hash(hall.floor)
    hall.never(hall.watch_s, lambda said: said.report.floor_hash != expected, f"floor_hash {expected:016x} in every report")


@SUITE.check("names-before-border", "Name an area from when the robot's outline reaches into it at the estimated pose")
def names_before_border(hall: Hall) -> None:
    """While it drives over a border the reported pose is in no area that `stands_in` does not name."""
    area = hall.ahead()
    hall.let_into(area)
    begin = len(hall.said)
    hall.expect(hall.patience_s, lambda said: area in said.report.stands_in, f"the robot in {area}")
    for said in hall.said[begin:]:
        x, y = said.report.pose.x_m, said.report.pose.y_m
        inside = [area.id for area in hall.floor if area.min_x_m < x < area.max_x_m and area.min_y_m < y < area.max_y_m]
        missing = [name for name in inside if name not in said.report.stands_in]
        if missing and said.report.located:
            raise Failed(f"stands_in with {missing[0]}, which the pose ({x:.2f}, {y:.2f}) is in", f"{list(said.report.stands_in)}")


@SUITE.check("report-size", "A message has at most 1048576 bytes.")
def report_size(hall: Hall) -> None:
    """No report is longer."""
    time.sleep(page.SILENT_S)
    if hall.longest > wire.LONGEST_MESSAGE:
        raise Failed(f"at most {wire.LONGEST_MESSAGE} bytes", str(hall.longest))
