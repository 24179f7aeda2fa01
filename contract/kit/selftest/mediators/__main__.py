"""`python -m kit.selftest.mediators NAME ENDPOINT PREFIX FOLDER`: a wrong mediator, or `right`, until the mediator behind it ends."""

from __future__ import annotations

import sys
from pathlib import Path

from . import WRONG, Relay

if __name__ == "__main__":
    name, endpoint, prefix, folder = sys.argv[1:]
    (Relay if name == "right" else WRONG[name][0])(prefix, Path(folder)).run(endpoint)
