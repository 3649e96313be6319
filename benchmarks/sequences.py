"""A sequence that is killed and resumed: all frames good, none made twice, nothing left over."""

from __future__ import annotations

import json
import random
import subprocess
import tempfile
import time
from contextlib import suppress
from pathlib import Path

from .program import octolux
from .registry import at_least, at_most, figure, within

FRAMES, KILLS, SEED = 40, 10, 3
WORDS = (
    "render", "cornell-box", "--size", "96x54", "--frames", f"0..{FRAMES - 1}", "--out", "f_####.png", "--out",
    "f_####.exr", "--out", "film.gif", "--stats", "stats.json",
)  # fmt: skip


def contents(folder: Path) -> dict[str, bytes]:
    """The files of frames and the video, whole."""
    return {p.name: p.read_bytes() for p in folder.glob("f*")}


def identities(folder: Path) -> dict[str, tuple[int, int]]:
    """What changes when a file is written again."""
    return {p.name: (p.stat().st_ino, p.stat().st_mtime_ns) for p in folder.glob("f*")}


def kill_and_resume(folder: Path, seconds: float, whole: dict[str, bytes]) -> dict[str, float]:
    """Start the sequence in an empty folder, SIGKILL it after so many seconds, resume it, and count what is wrong."""
    with suppress(subprocess.TimeoutExpired):  # subprocess.run has killed it then
        octolux(*WORDS, folder=folder, seconds=seconds)
    kept = identities(folder)
    complete = [k for k in range(FRAMES) if {f"f_{k:04d}.png", f"f_{k:04d}.exr"} <= kept.keys()]
    half = sum(data != whole[name] for name, data in contents(folder).items())
    temporary = len(list(folder.glob(".*")))
    (folder / "stats.json").unlink(missing_ok=True)
    done = octolux(*WORDS, "--resume", folder=folder)
    if done.returncode:
        raise RuntimeError(done.stderr.strip()[-300:])
    stats = folder / "stats.json"
    rendered = json.loads(stats.read_text())["frames"] if stats.exists() else 0  # none where all were complete
    after, found = identities(folder), contents(folder)
    return {
        "good_frames": sum(
            all(found.get(name := f"f_{k:04d}.{kind}") == whole[name] for kind in ("png", "exr")) for k in range(FRAMES)
        ),
        "half_written": half,
        "made_twice": max(0, rendered + len(complete) - FRAMES) + sum(after[name] != kept[name] for name in kept),
        "good_video": found.get("film.gif") == whole["film.gif"],
        "leftovers": sum(p.name not in whole and p != stats for p in folder.iterdir()),
        "kills_amid_frames": 0 < len(complete) < FRAMES,
        "kills_amid_a_file": temporary > 0,
    }


@figure(
    "kill_and_resume", group="sequences", unit={"kills_amid_frames": "kills", "kills_amid_a_file": "kills"},
    bound={
        "good_frames": within(FRAMES, 0), "half_written": at_most(0), "made_twice": at_most(0), "leftovers": at_most(0),
        "good_video": within(KILLS, 0), "kills_amid_frames": at_least(KILLS // 3),
        "kills_amid_a_file": at_least(KILLS // 3),
    },
)  # fmt: skip
def killed() -> dict[str, float]:
    """`kill -9` at ten moments spread over a sequence of 40 frames, PNG, EXR and GIF, each followed by `--resume`.

    The moments are random within each tenth of the time that the run takes from the start of the process, start-up
    included. `good_frames`: fewest with the bytes of a run that was not killed. `made_twice`: frames rendered, or files
    written, though they were complete. Sums over the ten, but for the first.
    """
    draw = random.Random(SEED)
    with tempfile.TemporaryDirectory() as folder:
        start = time.monotonic()
        octolux(*WORDS, folder=Path(folder))
        lasts = time.monotonic() - start
        whole = contents(Path(folder))
    found = []
    for tenth in range(KILLS):
        with tempfile.TemporaryDirectory() as folder:
            found.append(kill_and_resume(Path(folder), (tenth + draw.random()) / KILLS * lasts, whole))
    sums = {key: float(sum(one[key] for one in found)) for key in found[0]}
    return {**sums, "good_frames": float(min(one["good_frames"] for one in found))}
