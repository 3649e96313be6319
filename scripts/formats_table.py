"""Writes docs/formats.md, what octolux reads and writes against the tests of it: `.venv/bin/python
scripts/formats_table.py`. With --check it writes nothing, and fails when the page is not what it would write.

Tests say what they cover: `@pytest.mark.covers("glTF skins", "model .glb", files=["gltf/Fox/Fox.glb"])`. The first
word of a feature is its kind, a key of KINDS, and the rest its name there. files: those that the test reads, below
`scenes` of the data folder or in this repository; without them the test makes its own. broken=True: the test is of
damaged or wrong input. Of several marks of a test that name a feature, the nearest to it holds.
"""

from __future__ import annotations

import contextlib
import io
import sys
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from octolux.data import data_folder
from octolux.output import FORMATS as PICTURES
from octolux.output.video import VIDEOS
from octolux.scene.gltf.loader import SUPPORTED
from octolux.scene.images.decode import FORMATS as IMAGES
from octolux.scene.load import LOADERS

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "formats.md"

# What glTF 2.0 has without extensions, and is not read by merely opening a file.
CORE = (
    "alpha modes", "animation", "cameras", "embedded data", "generated normals", "generated tangents",
    "interleaved and normalized attributes", "materials", "morph targets", "nodes", "skins", "sparse accessors",
    "triangle strips and fans", "vertex colours",
)  # fmt: skip
KINDS = {
    "model": [*LOADERS, "NumPy arrays", "trimesh objects"],
    "glTF": [*sorted(SUPPORTED), *CORE],
    "image": [*IMAGES, "KTX2"],
    "environment": [".hdr", ".pic", ".exr", "pictures of 8 bits"],
    "output": [*PICTURES, ".png of 16 bits", ".png with alpha", *VIDEOS],
}
TITLES = {
    "model": "Models and scenes", "glTF": "glTF extensions and features", "image": "Images of textures",
    "environment": "Pictures of the surroundings", "output": "Outputs",
}  # fmt: skip
MOST_NAMED = 3
"""Files of one folder that are named one by one."""

HEAD = """# Formats and their tests

What octolux reads and writes, and the tests of each. This page is made from the marks of the tests by
`.venv/bin/python scripts/formats_table.py`; a format, extension or output without a test is an error there.

Numbers are those of test cases; one case may cover several rows. "Broken" cases give damaged or wrong input and expect
one error, or for outputs that what is not whole is found. Named files lie below `scenes` of the
[data folder](conventions.md#data-outside-the-repository), or in this repository. Beyond these tests,
`python -m benchmarks mutated` renders 5,000 damaged files of all kinds of models; a case of `test_mutated.py` loads 50
others. What is read of each format, and how, tells [models](models.md).
"""


@dataclass
class Coverage:
    """What is known of one feature: test cases by file, sample files, and whether tests make files of their own."""

    tests: Counter[str] = field(default_factory=Counter)
    broken: Counter[str] = field(default_factory=Counter)
    files: set[str] = field(default_factory=set)
    makes_own: bool = False


class Collector:
    """A pytest plugin that keeps the marks of all tests."""

    def __init__(self) -> None:
        self.found: dict[str, Coverage] = {}

    def pytest_collection_finish(self, session: pytest.Session) -> None:
        for item in session.items:
            seen: set[str] = set()
            for mark in item.iter_markers("covers"):  # the nearest first
                for feature in set(mark.args) - seen:
                    self.add(feature, item.path.relative_to(ROOT).as_posix(), **mark.kwargs)
                seen |= set(mark.args)

    def add(self, feature: str, test: str, files: Iterable[str] = (), broken: bool = False) -> None:
        coverage = self.found.setdefault(feature, Coverage())
        (coverage.broken if broken else coverage.tests)[test] += 1
        if not broken:
            coverage.files.update(files)
            coverage.makes_own |= not files


def collected() -> dict[str, Coverage]:
    """By feature, from pytest's own collection of the test files that have such marks."""
    marked = [str(p) for p in sorted((ROOT / "tests").rglob("test_*.py")) if "mark.covers(" in p.read_text("utf-8")]
    collector, printed = Collector(), io.StringIO()
    options = ["--collect-only", "-q", "--assert=plain", "--rootdir", str(ROOT), "-p", "no:cacheprovider"]
    with contextlib.redirect_stdout(printed):
        code = pytest.main([*options, *marked], plugins=[collector])
    if code != pytest.ExitCode.OK:
        sys.exit(f"{printed.getvalue()}\nthe tests cannot be collected")
    return collector.found


def problems(found: dict[str, Coverage]) -> list[str]:
    """Features without a test, features of tests that there are not, and sample files that there are not."""
    known = [f"{kind} {name}" for kind, names in KINDS.items() for name in names]
    told = [f"no test covers '{feature}'" for feature in known if feature not in found or not found[feature].tests]
    told += [f"a test covers '{feature}', which is not in KINDS" for feature in sorted(found) if feature not in known]
    folders = [ROOT, data_folder() / "scenes"]
    if folders[1].is_dir():
        named = {name for coverage in found.values() for name in coverage.files}
        told += [f"there is no file '{n}'" for n in sorted(named) if not any((f / n).is_file() for f in folders)]
    return told


def page(found: dict[str, Coverage]) -> str:
    """The text of docs/formats.md."""
    parts = [HEAD]
    for kind, names in KINDS.items():
        rows = [f"\n## {TITLES[kind]}\n", "| what | tested with | tests | broken |", "|---|---|---|---|"]
        for name in names:
            coverage = found.get(f"{kind} {name}", Coverage())
            first, *more = name.split(" ", 1)
            code = f"`{first}`" if first.startswith((".", "KHR_", "EXT_")) else first
            cells = " ".join([code, *more]), _sources(coverage), _counts(coverage.tests), _counts(coverage.broken)
            rows.append(f"| {' | '.join(cells)} |".replace("|  |", "| |"))
        parts.append("\n".join(rows) + "\n")
    return "".join(parts)


def _sources(coverage: Coverage) -> str:
    """What the tests make, and their sample files: those of a folder that has many as a number."""
    folders: dict[str, list[str]] = {}
    for name in sorted(coverage.files):
        folders.setdefault(name.rpartition("/")[0], []).append(name)
    told = ["made by the tests"] if coverage.makes_own else []
    for folder, names in folders.items():
        many = len(names) > MOST_NAMED
        told += [f"{len(names)} of `{folder}/`"] if many else [f"`{name}`" for name in names]
    return ", ".join(told)


def _counts(tests: Counter[str]) -> str:
    return ", ".join(f"[{Path(test).name}](../{test}) {tests[test]}" for test in sorted(tests))


def main() -> None:
    found = collected()
    told = problems(found)
    if told:
        sys.exit("\n".join(told))
    text = page(found)
    if "--check" not in sys.argv[1:]:
        PAGE.write_text(text, encoding="utf-8")
    elif not PAGE.is_file() or PAGE.read_text(encoding="utf-8") != text:
        sys.exit(f"{PAGE.relative_to(ROOT)} is not what the tests say: run scripts/formats_table.py")


if __name__ == "__main__":
    main()
