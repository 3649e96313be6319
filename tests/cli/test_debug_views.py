"""`octolux render --debug`: what a technique's light cache holds, as files."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

UNIFORM, CONES = ("--technique", "uniform-lpv", "--set", "n=16"), ("--technique", "voxel-cones", "--set", "depth=6")


def test_numbers_and_pictures(render, folder):
    done = render("cornell-box", *CONES, "--debug", "voxels:2:normal=n.png", "--debug", "nodes=n.npz")
    assert done.code == 0, done.err
    assert "wrote n.png" in done.out and "wrote n.npz" in done.out
    assert np.asarray(Image.open(folder / "n.png")).shape == (12, 16, 3)
    assert np.load(folder / "n.npz")["view"].shape[1] == 4


def test_views_of_several_levels(render, folder):
    done = render("cornell-box", "--technique", "octree-lpv", "--set", "n=16", "--debug", "injected=a.npz")
    assert done.code == 0, done.err
    levels = np.load(folder / "a.npz")
    assert levels["view_0"].shape == (16, 16, 16, 3, 4) and levels["view_1"].shape == (8, 8, 8, 3, 4)


def test_what_there_is(render, folder):
    for options, line in ((UNIFORM, "injected"), (CONES, "voxels:5:normal, opacity"), (CONES, "cones:COLUMN:ROW")):
        done = render("cornell-box", *options, "--debug", "list")
        assert done.code == 0 and line in done.out and not list(folder.iterdir())
    assert "has no debug views" in render("cornell-box", "--technique", "none", "--debug", "list").out


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ((*UNIFORM, "--debug", "injectd=a.npz"), "There is no debug view 'injectd'. Did you mean 'injected'?"),
        (("--technique", "none", "--debug", "injected=a.npz"), "this technique has none"),
        ((*UNIFORM, "--debug", "injected"), "--debug takes NAME=FILE"),
        ((*UNIFORM, "--debug", "injected="), "--debug takes NAME=FILE"),
        ((*UNIFORM, "--debug", "=a.npz"), "--debug takes NAME=FILE"),
        ((*UNIFORM, "--debug", "light=a.npz"), "There is no debug view 'light'. --debug list shows"),
        ((*CONES, "--debug", "cones:a:b=a.npz"), "There is no debug view 'cones:a:b'. Did you mean 'cones'?"),
        ((*UNIFORM, "--debug", "injected=a.jpg"), "a.jpg: files of the kind '.jpg' are not written"),
        ((*UNIFORM, "--debug", "injected=a.npz", "--resume"), "--resume may not render"),
        ((*UNIFORM, "--debug", "injected=a.png"), "a.png: this debug view is no picture"),
        ((*CONES, "--debug", "cones:0:0=a.png"), "a.png: this debug view is no picture"),
    ],
)
def test_what_is_refused_before_anything_is_rendered(render, folder, options, message):
    done = render("cornell-box", *options)
    assert done.code == 2 and message in done.err and not list(folder.iterdir())
