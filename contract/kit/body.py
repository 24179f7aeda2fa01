"""A simulated body: a disc that drives along straight lines, and brakes as it says."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Iterable

RADIUS_M = 0.2
# Named as stood in this much before the footprint is over a border: what the pose may be wrong by, and a step at full speed.
MARGIN_M = 0.1
BRAKE_M_S2 = 1.0
STEP_M = 0.02


@dataclass
class Body:
    """Where it is, how fast, and which points it drives through."""

    x_m: float
    y_m: float
    max_speed_m_s: float = 0.5
    speed_m_s: float = 0.0
    path: list[tuple[float, float]] = field(default_factory=list)

    def braking_m(self, speed_m_s: float | None = None) -> float:
        """The way until it stands, with a step of driving on before it brakes."""
        speed = self.speed_m_s if speed_m_s is None else speed_m_s
        return speed * speed / (2 * BRAKE_M_S2) + speed * 0.04

    def step(self, seconds: float, free_m: float) -> None:
        """Drives on, so that it stands within `free_m` at the latest, or as soon as it can."""
        target = min(self.max_speed_m_s, math.sqrt(2 * BRAKE_M_S2 * max(0.0, free_m - self.speed_m_s * 0.06)))
        change = BRAKE_M_S2 * seconds
        self.speed_m_s = max(0.0, min(max(target, self.speed_m_s - change), self.speed_m_s + change / 2))
        way = self.speed_m_s * seconds
        while way > 0 and self.path:
            (x, y), left = self.path[0], math.dist((self.x_m, self.y_m), self.path[0])
            if left <= way:
                self.x_m, self.y_m, way = x, y, way - left
                self.path.pop(0)
            else:
                self.x_m, self.y_m, way = self.x_m + (x - self.x_m) * way / left, self.y_m + (y - self.y_m) * way / left, 0.0
        if not self.path:
            self.speed_m_s = 0.0

    def ahead(self, length_m: float) -> Iterable[tuple[float, float, float]]:
        """Points on its way: how far, and where."""
        far, (x, y) = 0.0, (self.x_m, self.y_m)
        for to_x, to_y in self.path:
            line = math.dist((x, y), (to_x, to_y))
            for step in range(1, int(line / STEP_M) + 2):
                part = min(1.0, step * STEP_M / line) if line > 0 else 1.0
                if far + part * line > length_m:
                    return
                yield far + part * line, x + (to_x - x) * part, y + (to_y - y) * part
            far, x, y = far + line, to_x, to_y

    def left_m(self) -> float:
        """The way to the end of the path."""
        points = [(self.x_m, self.y_m), *self.path]
        return sum(math.dist(one, other) for one, other in zip(points, points[1:]))


def reaches(area: Any, x_m: float, y_m: float) -> bool:
    """Whether a robot there may reach into the area."""
    dx = max(area.min_x_m - x_m, 0.0, x_m - area.max_x_m)
    dy = max(area.min_y_m - y_m, 0.0, y_m - area.max_y_m)
    return math.hypot(dx, dy) < RADIUS_M + MARGIN_M


def centre(area: Any) -> tuple[float, float]:
    """The middle of an area."""
    return (area.min_x_m + area.max_x_m) / 2, (area.min_y_m + area.max_y_m) / 2
