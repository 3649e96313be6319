"""Scenes too large to be computed with."""

from __future__ import annotations

import pytest

from octolux.scene.errors import SceneError
from octolux.scene.load import load_scene

pytestmark = pytest.mark.covers("model .toml", broken=True)

OBJ = "g far\nv 0 0 0\nv {0} 0 0\nv 0 {0} 0\nf 1 2 3\n"


def write(tmp_path, name: str, text: str):
    (tmp_path / name).write_text(text)
    return tmp_path / name


def test_up_to_1e15_metres(tmp_path):
    assert load_scene(write(tmp_path, "a.obj", OBJ.format("1e15"))).triangle_count == 1
    with pytest.raises(SceneError, match=r"a.obj: object 'far': reaches further than 1e\+15 m"):
        load_scene(write(tmp_path, "a.obj", OBJ.format("1.1e15")))


@pytest.mark.parametrize("line", ["scale = 1e20", "scale = 1e30", "unit = 1e16", "translate = [0, -2e15, 0]",
                                  "matrix = [[1,0,0,1e16],[0,1,0,0],[0,0,1,0],[0,0,0,1]]"])  # fmt: skip
def test_models_moved_or_scaled_away(tmp_path, line):
    write(tmp_path, "a.obj", OBJ.format("1"))
    with pytest.raises(SceneError) as caught:
        load_scene(write(tmp_path, "s.toml", f'[[model]]\nfile = "a.obj"\n{line}\n'))
    assert "1e+15 m" in caught.value.problem
    assert caught.value.file == str(tmp_path / "s.toml")


def test_scales_that_multiply_beyond_all_numbers(tmp_path):
    write(tmp_path, "a.obj", OBJ.format("1e30"))
    for depth in range(12):
        inner = f"s{depth - 1}.toml" if depth else "a.obj"
        path = write(tmp_path, f"s{depth}.toml", f'[[model]]\nfile = "{inner}"\nscale = 1e30\n')
    with pytest.raises(SceneError, match=r"1e\+15 m"):
        load_scene(path)
