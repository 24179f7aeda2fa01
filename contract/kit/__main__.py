"""`python -m kit mediator`, `python -m kit robot`, `python -m kit selftest`; each has `--help`."""

from __future__ import annotations

import sys
from pathlib import Path

if not __package__:
    # Started as a folder: the package is above it.
    sys.path[0] = str(Path(__file__).resolve().parent.parent)
    __package__ = "kit"

from kit.command import main  # noqa: E402

if __name__ == "__main__":
    sys.exit(main())
