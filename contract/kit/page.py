"""What PROTOCOL.md says, found in the page itself: its sentences and its times."""

from __future__ import annotations

import re
from pathlib import Path

PAGE = Path(__file__).resolve().parent.parent / "PROTOCOL.md"


def normalised(text: str) -> str:
    """With single spaces, so that line breaks do not matter."""
    return " ".join(text.split())


TEXT = normalised(PAGE.read_text(encoding="utf-8"))


def says(sentence: str) -> bool:
    """Whether the page has this sentence, or this row of a table, word for word."""
    return normalised(sentence) in TEXT


def time_s(what: str) -> float:
    """A time of the table at the end of the page, seconds."""
    found = re.search(rf"\| {re.escape(what)} \| ([\d.]+) (ms|s) \|", TEXT)
    if found is None:
        raise ValueError(f"PROTOCOL.md has no time for `{what}`")
    return float(found.group(1)) / (1000.0 if found.group(2) == "ms" else 1.0)


def version() -> tuple[int, int]:
    """The version that the page is of."""
    found = re.match(r"# Protocol, version (\d+)\.(\d+) ", TEXT)
    if found is None:
        raise ValueError("PROTOCOL.md does not say its version at its top")
    return int(found.group(1)), int(found.group(2))


VERSION = version()
LEVEL_S = time_s("a level is sent at least every")
SILENT_S = time_s("whoever was not heard for longer is silent")
LEASE_S = time_s("lease: reports are as old as this, at most")
LISTENS_FIRST_S = time_s("a process that was just registered enters nothing for")
ENTERS_WITHIN_S = time_s("from the last moment to reach in until it has or stands")
ENTERS_NO_MORE_S = time_s("a silent robot enters nothing any more after")
ASKED_AGAIN_S = time_s("a grant that was kept and not entered is asked back again after")
ACQUIRED_S = time_s("`acquire` is answered within")
DOUBLED_S = time_s("two that speak at once are told to people after")
CANDIDATE_S = time_s("a process that was offered a session repeats it within")
