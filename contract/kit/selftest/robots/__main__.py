"""`python -m kit.selftest.robots NAME ...`: a wrong robot, or `right`, with the options of `kit.robot`."""

from __future__ import annotations

import sys

from ...link import Link
from ...robot import run
from . import WRONG, Robot

if __name__ == "__main__":
    name, *rest = sys.argv[1:]
    kind = Robot if name == "right" else WRONG[name][0]
    run(kind, rest, getattr(kind, "link", Link))
