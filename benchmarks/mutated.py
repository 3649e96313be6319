"""Valid scenes with faults in them, 5,000: one clear error or a picture, and nothing else.

"noise" are warnings of libraries on stderr, "not_finite" pictures with pixels that are no numbers. A hang is one step,
such as a run of the program, of more than 20 s.

Every case goes through the program's own `octolux info`, which loads it. What that takes is loaded, moved to one second
and rendered twice, by one renderer that all cases of a worker share, since a program of its own for each would take two
hours. Every sixteenth case is also rendered by `octolux render`, which makes its own device and renderer.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from typing import Any

from .lab import data
from .registry import at_most, figure, within

CASES = 5000
SECONDS = 20.0
MOST_BYTES = 2 << 30
_RENEW = 1 << 30  # a worker that has come to hold so much is replaced, for what it keeps is not the next case's
_FAULTS = ("tracebacks", "several_errors", "noise", "not_finite", "hangs", "crashes", "over_memory")
_UNITS = {**dict.fromkeys(("cases", "pictures", "refused", *_FAULTS), "cases"), "longest": "s", "most_memory": "MB"}
_REPOSITORY = Path(__file__).resolve().parents[1]


class Worker:
    """A process that runs cases; killed when one takes too long, and then started again."""

    def __init__(self) -> None:
        self.process: subprocess.Popen[str] | None = None

    def run(self, case: int) -> dict[str, Any]:
        """The answer of `mutated_child`, or one that says how the process ended."""
        process = self.process or self._started()
        assert process.stdin
        hung = threading.Event()
        with suppress(BrokenPipeError):
            print(case, file=process.stdin, flush=True)
        while (line := self._line(process, hung)) == "step\n":
            pass
        if line:
            found: dict[str, Any] = json.loads(line)
            if found["bytes"] > _RENEW:
                self.stop()
            return found
        code = process.wait()
        self.stop()
        kind, text = ("hangs", "") if hung.is_set() else ("crashes", f"exit code {code}")
        return {"case": case, "outcome": "", "faults": {kind: text}, "seconds": SECONDS, "bytes": 0}

    def _line(self, process: subprocess.Popen[str], hung: threading.Event) -> str:
        """The next line of its answer; empty when it has ended, or had to be killed."""

        def kill() -> None:
            hung.set()
            self.kill()

        assert process.stdout
        watchdog = threading.Timer(SECONDS, kill)
        watchdog.start()
        line = process.stdout.readline()
        watchdog.cancel()
        return line

    def _started(self) -> subprocess.Popen[str]:
        environment = {**os.environ, "PYTHONPATH": str(_REPOSITORY), "OCTOLUX_CACHE": "off", "COLUMNS": "200"}
        self.process = subprocess.Popen(
            [sys.executable, "-m", "benchmarks.mutated_child"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            text=True, env=environment, start_new_session=True,
        )  # fmt: skip
        assert self.process.stdout
        if self.process.stdout.readline().strip() != "ready":
            raise RuntimeError("benchmarks.mutated_child does not start")
        return self.process

    def kill(self) -> None:
        """Kill the process and its children, which are in a session of their own."""
        if self.process is not None:
            with suppress(ProcessLookupError):
                os.killpg(self.process.pid, signal.SIGKILL)

    def stop(self) -> None:
        """End the process; the next case starts another."""
        self.kill()
        if self.process is not None:
            self.process.wait()
            self.process = None


def answers(cases: range, workers: int) -> Iterator[dict[str, Any]]:
    """The answers for all cases, in any order."""
    local = threading.local()
    made: list[Worker] = []

    def run(case: int) -> dict[str, Any]:
        if not hasattr(local, "worker"):
            local.worker = Worker()
            made.append(local.worker)
        return local.worker.run(case)  # type: ignore[no-any-return]

    try:
        with ThreadPoolExecutor(workers) as threads:
            yield from threads.map(run, cases)
    finally:
        for worker in made:
            worker.stop()


def _note(found: dict[str, Any]) -> None:
    if found["bytes"] > MOST_BYTES:
        found["faults"]["over_memory"] = f"{found['bytes'] / 1e6:.0f} MB"
    for kind, text in found["faults"].items():
        print(f"case {found['case']}: {kind}: {text}", file=sys.stderr, flush=True)


@figure("mutated", group="bad_input", unit=_UNITS,
        bound={"cases": within(CASES, 0), **{kind: at_most(0) for kind in _FAULTS}})  # fmt: skip
def mutated(cases: range = range(CASES)) -> dict[str, float]:
    """5,000 damaged scenes of all kinds, repeatable: pictures or one error each; at most 20 s and 2 GiB for a case.

    `python -m benchmarks.mutations K FOLDER` writes case K.
    """
    data("scenes")
    totals: Counter[str] = Counter(dict.fromkeys(("cases", "pictures", "refused", *_FAULTS), 0))
    longest, most = 0.0, 0
    for found in answers(cases, min(4, os.cpu_count() or 1)):
        _note(found)
        totals.update(found["faults"].keys())
        totals["cases"] += 1
        totals["pictures" if found["outcome"] == "picture" else "refused"] += bool(found["outcome"])
        longest, most = max(longest, found["seconds"]), max(most, found["bytes"])
    return {**totals, "longest": longest, "most_memory": most / 1e6}
