"""What a check is, which there are, and how they are run, listed and reported."""

from __future__ import annotations

import json
import sys
import time
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Callable, Sequence

from . import page


class Failed(Exception):
    """The other side does not do what the sentence says."""

    def __init__(self, expected: str, found: str) -> None:
        super().__init__(f"expected {expected}; found {found}")
        self.expected, self.found = expected, found


class Skipped(Exception):
    """The check cannot be made here; the message says what it takes."""


class Mute(Exception):
    """The other side never speaks: no check can be made."""


@dataclass(frozen=True)
class Check:
    """A check: its stable name, the sentences that it holds the other side to, what it takes, and what is done."""

    name: str
    about: str
    sentences: tuple[str, ...]
    needs: tuple[str, ...]
    fresh: bool
    run: Callable[[Any], None]


@dataclass
class Suite:
    """All checks of one side, in the order in which they are run."""

    side: str
    checks: list[Check] = field(default_factory=list)

    def check(self, name: str, *sentences: str, needs: Sequence[str] = (), fresh: bool = False) -> Callable[[Callable[[Any], None]], Any]:
        """Adds the function as a check. Its docstring says in a line what is checked. A `fresh` one begins with a start of its own:
        nothing need be ready before it."""
        def add(run: Callable[[Any], None]) -> Callable[[Any], None]:
            about = page.normalised(run.__doc__ or "")
            self.checks.append(Check(name, about, sentences, tuple(needs), fresh, run))
            return run

        return add

    def errors(self) -> list[str]:
        """What is wrong with the checks themselves: sentences that the page does not have, names used twice."""
        found = [f"{check.name}: PROTOCOL.md does not say: {sentence}"
                 for check in self.checks for sentence in check.sentences if not page.says(sentence)]
        found += [f"{check.name}: no sentence" for check in self.checks if not check.sentences]
        found += [f"{check.name}: no docstring" for check in self.checks if not check.about]
        names = [check.name for check in self.checks]
        return found + [f"{name}: used twice" for name in sorted(set(names)) if names.count(name) > 1]

    def select(self, only: str | None) -> list[Check]:
        """Those with these names, separated by commas; all without."""
        if not only:
            return self.checks
        names = [name.strip() for name in only.split(",") if name.strip()]
        unknown = set(names) - {check.name for check in self.checks}
        if unknown:
            print(f"--only: found {', '.join(sorted(unknown))}, expected names of checks; see --list")
            raise SystemExit(2)
        return [check for check in self.checks if check.name in names]

    def list(self, markdown: bool) -> str:
        """All checks with their sentences."""
        if not markdown:
            return "\n".join(f"{check.name}\n    {check.about}\n" + "\n".join(f"    > {page.normalised(sentence)}" for sentence in
                             check.sentences) for check in self.checks)
        lines = ["| check | what it holds the other side to | takes |", "|---|---|---|"]
        lines += [f"| `{check.name}` | {check.about} | {', '.join(check.needs)} |" for check in self.checks]
        return "\n".join(lines)


@dataclass
class Result:
    """What came of a check."""

    name: str
    outcome: str
    expected: str = ""
    found: str = ""
    took_s: float = 0.0
    sentences: tuple[str, ...] = ()


def run_one(check: Check, around: Any) -> Result:
    """Runs a check in its surroundings, which `prepare` it and `tidy` up after it."""
    begin = time.monotonic()
    result = Result(check.name, "ok", sentences=check.sentences)
    try:
        around.provide(check.needs)
        around.prepare(check.fresh)
        check.run(around)
    except Failed as error:
        result.outcome, result.expected, result.found = "FAILED", error.expected, error.found
    except Skipped as error:
        result.outcome, result.found = "skipped", str(error)
    except (AssertionError, AttributeError, LookupError, TypeError, ValueError) as error:
        # What the other side says is not what the check can follow at all.
        result.outcome, result.expected, result.found = "FAILED", "what the check can follow", f"{type(error).__name__}: {error}"
    finally:
        around.tidy(result.outcome)
    result.took_s = round(time.monotonic() - begin, 1)
    return result


def show(result: Result, out: Any = sys.stdout) -> None:
    """Prints a result at once."""
    print(f"{result.outcome:8}{result.name}  ({result.took_s} s)", file=out)
    if result.outcome == "FAILED":
        for sentence in result.sentences:
            print(f"    PROTOCOL.md: {page.normalised(sentence)}", file=out)
        print(f"    expected: {result.expected}\n    found:    {result.found}", file=out)
    elif result.outcome == "skipped":
        print(f"    {result.found}", file=out)
    out.flush()


def run_all(checks: Sequence[Check], around: Any, json_file: str | None) -> int:
    """Runs the checks one after the other. Returns 0 only if all that were run have passed, and some were."""
    begin, results = time.monotonic(), list[Result]()
    try:
        for check in checks:
            results.append(run_one(check, around))
            show(results[-1])
    except Mute as error:
        results.append(Result("speaks", "FAILED", "messages of the other side", str(error)))
        show(results[-1])
    finally:
        # Also when it is interrupted.
        code = close(results, len(checks), begin, json_file)
    return code


def close(results: Sequence[Result], asked: int, begin: float, json_file: str | None) -> int:
    """Counts and writes the results. Returns the exit code."""
    count = {outcome: sum(result.outcome == outcome for result in results) for outcome in ("ok", "FAILED", "skipped")}
    left = asked - sum(result.name != "speaks" for result in results)
    print(f"{count['ok']} ok, {count['FAILED']} failed, {count['skipped']} skipped, {left} not run, of {asked} checks in "
          f"{time.monotonic() - begin:.0f} s", flush=True)
    if json_file:
        Path(json_file).write_text(json.dumps([asdict(result) for result in results], indent=1), encoding="utf-8")
    return 0 if count["ok"] > 0 and count["FAILED"] == 0 else 1
