"""Files appear whole or not at all; what killed runs leave is cleaned up, what living ones write is not."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from octolux.output.atomic import remove_leftovers, replacing
from octolux.scene.errors import OctoluxError

WRITER = """
import sys
from pathlib import Path
from octolux.output.atomic import replacing
with replacing(Path("a.png")) as temporary:
    temporary.write_text("half a pict")
    print("writing", flush=True)
    sys.stdin.read()
"""


@pytest.mark.parametrize("problem", [OSError(28, "No space left on device"), KeyboardInterrupt(), ValueError()])
@pytest.mark.parametrize("before", ["precious", None])
def test_a_writer_that_fails_leaves_nothing(folder, problem, before):
    path = folder / "a.png"
    if before:
        path.write_text(before)
    expected = OctoluxError if isinstance(problem, OSError) else type(problem)
    with pytest.raises(expected), replacing(path) as temporary:
        temporary.write_text("half a pict")
        raise problem
    assert {p.name: p.read_text() for p in folder.iterdir()} == ({"a.png": before} if before else {})


def test_the_file_is_not_there_before_it_is_whole(folder):
    with replacing(folder / "a.png") as temporary:
        temporary.write_text("all of it")
        assert not (folder / "a.png").exists()
        assert temporary.parent == folder  # renamed, not copied
    assert [(p.name, p.read_text()) for p in folder.iterdir()] == [("a.png", "all of it")]


def test_leftovers(folder):
    """A file that is being written stays; once its writer is killed it goes; other files are not touched."""
    for name in ("a.png", ".octolux", "octolux-a.png", ".hidden.png"):
        (folder / name).write_text("precious")
    writer = subprocess.Popen([sys.executable, "-c", WRITER], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    try:
        assert writer.stdout is not None
        assert writer.stdout.readline() == b"writing\n"
        assert remove_leftovers(folder) == 0
        assert len(list(folder.iterdir())) == 5
    finally:
        writer.kill()
        writer.communicate()
    assert remove_leftovers(folder) == 1
    assert {p.name: p.read_text() for p in folder.iterdir()} == dict.fromkeys(
        ("a.png", ".octolux", "octolux-a.png", ".hidden.png"), "precious"
    )


def test_a_file_of_this_process_is_no_leftover(folder):
    with replacing(folder / "a.png") as temporary:
        temporary.write_text("all of it")
        assert remove_leftovers(folder) == 0
    assert (folder / "a.png").read_text() == "all of it"


def test_a_long_name(folder):
    """The temporary name is no longer than file systems allow."""
    path = Path(folder, "n" * 250 + ".png")
    with replacing(path) as temporary:
        temporary.write_text("all of it")
    assert path.read_text() == "all of it"
