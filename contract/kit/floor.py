"""The floor that both sides must know alike: its hash, and a floor for robots that bring none."""

from __future__ import annotations

import math
from typing import Any, Iterable

from . import wire

HASH_OF_NOTHING = 0xCBF29CE484222325


def millimetres(metres: float) -> int:
    """Whole millimetres, rounded half away from zero."""
    return int(math.copysign(math.floor(abs(metres) * 1e3 + 0.5), metres))


def line(area: Any) -> str:
    """What the hash takes in of one area."""
    corners = (area.min_x_m, area.min_y_m, area.max_x_m, area.max_y_m)
    return "\t".join([area.id, str(area.capacity), *(str(millimetres(at)) for at in corners)]) + "\n"


def floor_hash(areas: Iterable[Any]) -> int:
    """FNV-1a with 64 bits over a line for each area, in the order of the ids' bytes."""
    found = HASH_OF_NOTHING
    for area in sorted(areas, key=lambda area: area.id.encode()):
        for byte in line(area).encode():
            found = (found ^ byte) * 0x100000001B3 % 2**64
    return found


def area(name: str, capacity: int, left: float, bottom: float, right: float, top: float) -> Any:
    """An area as messages carry it."""
    return wire.FloorArea(id=name, capacity=capacity, min_x_m=left, min_y_m=bottom, max_x_m=right, max_y_m=top)


def row(names: Iterable[str] = ("a", "b", "c", "d"), length_m: float = 1.5) -> list[Any]:
    """Areas for one robot each, side by side along x, 2 m wide."""
    return [area(name, 1, at * length_m, -1.0, (at + 1) * length_m, 1.0) for at, name in enumerate(names)]
