"""`python -m benchmarks.mutated_child`: runs the cases of `mutations` that standard input names, one a line.

Answers each with a line of JSON: "outcome" (picture or refused), "faults" by kind, "seconds" of its longest step and
"bytes" of memory. The line "ready" says that everything is imported and the device is made; a line "step" that one of
a case's steps begins.
"""

from __future__ import annotations

import json
import os
import re
import sys
import tempfile
import threading
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from itertools import pairwise
from pathlib import Path
from typing import Any, TextIO

import numpy as np

import octolux
from octolux.cli import main
from octolux.frame.frame import FrameSettings
from octolux.gpu.device import Device
from octolux.scene.errors import OctoluxError
from octolux.scene.load import load_scene
from octolux.scene.scene import Scene

from .mutations import write_case

SIZE = (32, 18)
SETTINGS = FrameSettings(shadow_resolution=64, rsm_resolution=16)
CLI_EVERY = 16
LONGEST_LINE = 600
_SAMPLE = 0.02  # seconds between looks at the memory of child processes
_RENDER = ("--size", "32x18", "--technique", "none", "--anti-aliasing", "off", "--shadow-resolution", "64",
           "--rsm-resolution", "16", "--frames", "0..1", "--fps", "1", "--out", "picture.png", "--out",
           "picture.exr")  # fmt: skip


class Case:
    """One scene put through the program. outcome: "picture" or "refused"; faults: texts by kind."""

    def __init__(self, number: int, path: Path, errors: int, renderer: Callable[[], octolux.Renderer],
                 begin: Callable[[], None]):
        self.number, self.path, self.errors, self.renderer, self.begin = number, path, errors, renderer, begin
        self.outcome, self.faults = "refused", dict[str, str]()

    def run(self) -> None:
        """`octolux info` first; what it takes is moved and rendered, every CLI_EVERY-th by `octolux render` too."""
        if self._program("info", str(self.path)):
            self._render()
            if self.number % CLI_EVERY == 0:
                self._program("render", str(self.path), *_RENDER)

    def _program(self, *words: str) -> bool:
        """Run `octolux WORDS`, and look at what it says when it refuses. Whether it ends well."""
        self.begin()
        os.ftruncate(self.errors, 0)
        os.lseek(self.errors, 0, os.SEEK_SET)
        code = _exit_code(words)
        sys.stderr.flush()
        told = os.pread(self.errors, 1 << 20, 0).decode(errors="replace")
        lines = told.splitlines()
        wrong = [line for line in lines if line.startswith("error:")]
        if code not in (0, 2) or "Traceback" in told:
            self.faults["tracebacks"] = f"{words[0]}: exit code {code}: {told[-3000:]}"
        elif "Warning: " in told:
            self.faults["noise"] = f"{words[0]}: {told[-500:]!r}"
        elif len(wrong) != (1 if code else 0) or (code and len(lines) != len(wrong)):
            self.faults["several_errors"] = f"{words[0]}: exit code {code}: {told[:500]!r}"
        elif code and not len("error: ") + 10 < len(wrong[0]) <= LONGEST_LINE:
            self.faults["several_errors"] = f"{words[0]}: {len(wrong[0])} characters: {told[:200]!r}"
        return code == 0

    def _render(self) -> None:
        self.begin()
        try:
            scene = load_scene(self.path)
            scene.bounds()
            for shown in (scene, scene.at(1.0)):
                self._picture(shown)
            self.outcome = "picture"
        except OctoluxError as error:
            self.outcome = f"refused: {error}"
        except Exception:
            self.faults["tracebacks"] = traceback.format_exc()[-3000:]

    def _picture(self, scene: Scene) -> None:
        self.begin()
        renderer = self.renderer()
        renderer.scene, renderer.exposure = scene, scene.exposure
        picture = renderer.render()
        if not np.isfinite(picture.radiance).all() or not np.isfinite(picture.display).all():
            self.faults["not_finite"] = "a pixel is not finite"


def _exit_code(words: tuple[str, ...]) -> Any:
    sys.argv = ["octolux", *words]
    try:
        main()
    except SystemExit as stop:
        return stop.code or 0
    except BaseException:
        traceback.print_exc()
        return "exception"
    return 0


class Renderers:
    """One renderer for all cases, for building its shaders takes a second; a new one after it has failed."""

    def __init__(self) -> None:
        self.device = Device()
        self.made: octolux.Renderer | None = None

    def __call__(self) -> octolux.Renderer:
        if self.made is None:
            self.made = octolux.Renderer(octolux.Scene(), "none", size=SIZE, device=self.device,
                                         frame_settings=SETTINGS)  # fmt: skip
        self.made.previous = None
        return self.made


@contextmanager
def _peak() -> Iterator[Callable[[], int]]:
    """Gives a function: the most memory, bytes, of this process and its children since the start (Linux)."""
    with suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")  # the high-water mark begins anew
    children: dict[str, int] = {}
    done = threading.Event()

    def watch() -> None:
        while not done.wait(_SAMPLE):
            for task in Path("/proc/self/task").iterdir():
                with suppress(OSError):
                    for child in (task / "children").read_text().split():
                        children[child] = max(children.get(child, 0), _high_water(child))

    thread = threading.Thread(target=watch, daemon=True)
    thread.start()
    yield lambda: _high_water("self") + max(children.values(), default=0)
    done.set()
    thread.join()


def _high_water(process: str) -> int:
    """Most memory of a process, bytes; 0 when it has ended, or is just becoming another program."""
    with suppress(OSError):
        own, other = (Path(f"/proc/{name}/cmdline").read_bytes() for name in ("self", process))
        found = re.search(r"VmHWM:\s+(\d+) kB", Path(f"/proc/{process}/status").read_text())
        if found and (process == "self" or own != other):
            return int(found[1]) * 1024
    return 0


def answer(number: int, errors: int, renderers: Renderers, answers: TextIO) -> dict[str, Any]:
    times: list[float] = []

    def begin() -> None:
        times.append(time.perf_counter())
        print("step", file=answers, flush=True)

    with tempfile.TemporaryDirectory() as folder, _peak() as peak:
        os.chdir(folder)
        case = Case(number, write_case(number, Path(folder)), errors, renderers, begin)
        case.run()
        times.append(time.perf_counter())
        used = peak()
    if "tracebacks" in case.faults:
        renderers.made = None
    seconds = max(after - before for before, after in pairwise(times))
    return {"case": number, "outcome": case.outcome, "faults": case.faults, "seconds": seconds, "bytes": used}


def serve() -> None:
    """Standard output is kept for the answers; what the program prints goes nowhere, its errors into a file."""
    answers = os.fdopen(os.dup(1), "w")
    errors = os.open(tempfile.gettempdir(), os.O_TMPFILE | os.O_RDWR)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    renderers = Renderers()
    renderers().render()
    os.dup2(errors, 2)
    print("ready", file=answers, flush=True)
    for line in sys.stdin:
        print(json.dumps(answer(int(line), errors, renderers, answers)), file=answers, flush=True)


if __name__ == "__main__":
    serve()
