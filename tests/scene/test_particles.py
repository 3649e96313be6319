"""Particle lights: what they keep, what they refuse, how they move, and TOML that makes them."""

from __future__ import annotations

import numpy as np
import pytest

from octolux.export.files import FileFolder
from octolux.export.mitsuba import mitsuba_description
from octolux.scene.cameras import Camera
from octolux.scene.compose import combined, placed
from octolux.scene.errors import SceneError
from octolux.scene.nodes import Node
from octolux.scene.particles import MOST_PARTICLES, ParticleLights
from octolux.scene.scene import Scene
from octolux.simulator import direct

POINTS = np.arange(12.0).reshape(4, 3)
COLORS = 1.0 + np.arange(12.0).reshape(4, 3)
HEAD = '[[light]]\ntype = "particles"\nname = "sparks"\n'
BOX = "box = [[0, 0, 0], [1, 2, 3]]\n"


def test_one_colour_is_each_particles_own():
    group = ParticleLights(positions=POINTS.tolist(), intensities=(1, 2, 3), name="sparks")
    np.testing.assert_array_equal(group.intensities, np.tile([1.0, 2.0, 3.0], (4, 1)))
    assert group.positions.dtype == group.intensities.dtype == np.float64


def test_a_group_is_not_changed_by_its_arrays():
    positions = POINTS.copy()
    group = ParticleLights(positions=positions, intensities=COLORS)
    positions[0] = 100.0
    np.testing.assert_array_equal(group.positions, POINTS)
    with pytest.raises(ValueError, match="read-only"):
        group.positions[0] = 1.0


@pytest.mark.parametrize(("positions", "intensities", "message"), [
    (POINTS[:, :2], 1.0, r"positions: have the shape \(4, 2\). Give \(N, 3\)"),
    (POINTS[0], (1, 1, 1), r"positions: have the shape \(3,\)"),
    ("here", (1, 1, 1), "positions: are no array of numbers"),
    ([[0, 1, np.nan]], (1, 1, 1), "positions: hold a number that is not finite"),
    ([[0, 1, 1e31]], (1, 1, 1), "positions: hold a number .* too large"),
    (np.zeros((MOST_PARTICLES + 1, 3)), (1, 1, 1), "positions: are 1,048,577. Give at most 1,048,576"),
    (POINTS, COLORS[:3], r"intensities: have the shape \(3, 3\). Give \(4, 3\), or \(3,\)"),
    (POINTS, 1.0, r"intensities: have the shape \(\)"),
    (POINTS, (1, np.inf, 1), "intensities: hold a number that is not finite"),
    (POINTS, (1, -2, 1), "intensities: hold -2. Give candela from 0"),
], ids=lambda value: value if isinstance(value, str) else "")  # fmt: skip
def test_mistakes_are_named(positions, intensities, message):
    with pytest.raises(SceneError, match="(?i)^ParticleLights 'sparks': " + message):
        ParticleLights(positions=positions, intensities=intensities, name="sparks")


def test_a_placed_scene_takes_its_particles_along_and_keeps_their_intensity():
    scene = Scene(lights=[ParticleLights(positions=POINTS, intensities=COLORS)])
    matrix = np.array([[0.0, 0.0, 2.0, 1.0], [0.0, 3.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 5.0], [0.0, 0.0, 0.0, 1.0]])
    moved = placed(scene, matrix).lights[0]
    np.testing.assert_allclose(moved.positions, POINTS @ matrix[:3, :3].T + matrix[:3, 3])
    np.testing.assert_array_equal(moved.intensities, COLORS)


def test_scenes_with_nodes_and_particles_go_together():
    scene = Scene(lights=[ParticleLights(positions=POINTS, intensities=COLORS)], nodes=[Node()])
    both = combined([scene, scene], "both")
    assert len(both.lights) == 2 and len(both.nodes) == 2
    np.testing.assert_array_equal(both.lights[1].positions, POINTS)
    np.testing.assert_array_equal(both.at(1.0).lights[0].positions, POINTS)


def test_irradiance_is_the_sum_over_the_particles():
    """Two particles 2 m above and beside: I / 4, and I cos 45 / 8; one below the horizon adds nothing."""
    group = ParticleLights(positions=[[0, 2, 0], [2, 2, 0], [0, -1, 0]], intensities=[[4, 0, 0], [0, 8, 0], [0, 0, 1]])
    found = direct.irradiance(group, np.zeros((1, 3)), np.array([0.0, 1.0, 0.0]))
    np.testing.assert_allclose(found, [[1.0, np.sqrt(0.5), 0.0]])


def test_mitsuba_is_given_each_particle(tmp_path):
    scene = Scene(lights=[ParticleLights(positions=POINTS, intensities=COLORS)])
    made = mitsuba_description(scene, Camera.look_at((0, 0, 1), (0, 0, 0)), (4, 4), FileFolder(tmp_path / "files"))
    lights = [value for value in made.values() if isinstance(value, dict) and value.get("type") == "point"]
    np.testing.assert_array_equal([light["position"] for light in lights], POINTS)
    np.testing.assert_array_equal([light["intensity"]["value"] for light in lights], COLORS)


def test_toml_strews_particles_evenly_and_alike_each_time(toml):
    """The mean of 10,000 evenly strewn points lies within 4 standard errors, 4 size / sqrt(12 N), of the middle."""
    text = HEAD + "count = 10000\nseed = 3\nintensity = [1, 2, 3]\n" + BOX
    group, again = toml(text).lights[0], toml(text).lights[0]
    size = np.array([1.0, 2.0, 3.0])
    assert group.name == "sparks" and group.positions.shape == (10000, 3)
    assert (group.positions >= 0).all() and (group.positions <= size).all()
    assert (np.abs(group.positions.mean(axis=0) - 0.5 * size) <= 4.0 * size / np.sqrt(12 * 10000)).all()
    np.testing.assert_array_equal(group.positions, again.positions)
    np.testing.assert_array_equal(group.intensities[0], [1.0, 2.0, 3.0])
    assert (toml(text.replace("seed = 3", "seed = 4")).lights[0].positions != group.positions).any()


@pytest.mark.parametrize("suffix", [".npy", ".npz", ".csv"])
@pytest.mark.parametrize("coloured", [True, False])
def test_toml_reads_particles_from_files(toml, tmp_path, suffix, coloured):
    path = tmp_path / f"sparks{suffix}"
    rows = np.hstack([POINTS, COLORS]) if coloured else POINTS
    if suffix == ".npy":
        np.save(path, rows.astype(np.float32))
    elif suffix == ".csv":
        np.savetxt(path, rows, delimiter=",", header="x, y, z")
    else:
        np.savez_compressed(path, positions=POINTS, **({"intensities": COLORS} if coloured else {}))
    group = toml(HEAD + f'file = "{path.name}"\n' + ("" if coloured else "intensity = 2\n")).lights[0]
    np.testing.assert_array_equal(group.positions, POINTS)
    np.testing.assert_array_equal(group.intensities, COLORS if coloured else np.full((4, 3), 2.0))


def files(folder) -> None:
    np.save(folder / "good.npy", POINTS)
    np.save(folder / "coloured.npy", np.hstack([POINTS, COLORS]))
    np.save(folder / "flat.npy", POINTS.ravel())
    np.save(folder / "negative.npy", np.hstack([POINTS, -COLORS]))
    np.save(folder / "objects.npy", np.array([{}, {}], dtype=object), allow_pickle=True)
    np.savez(folder / "other.npz", places=POINTS)
    np.savez_compressed(folder / "bomb.npz", positions=np.zeros((1 << 22, 3)))
    np.savez(folder / "complex.npz", positions=np.array([["a", "b", "c"]]))
    (folder / "words.csv").write_text("x,y,z\n1,2,3\n")
    (folder / "cut.npy").write_bytes((folder / "good.npy").read_bytes()[:-8])
    (folder / "text.npz").write_text("no archive")
    (folder / "huge.npy").write_bytes(
        (folder / "good.npy").read_bytes().replace(b"(4, 3), }        ", b"(40000000000, 3)}")
    )


MISTAKES = {
    "nothing given": (HEAD, "file", "is missing", "count, box and seed"),
    "no intensity": (HEAD + 'file = "good.npy"\n', "intensity", "is missing", "3 numbers"),
    "two intensities": (HEAD + 'file = "coloured.npy"\nintensity = 1\n', "intensity", "holds intensities", "leave it"),
    "file and count": (HEAD + 'file = "good.npy"\ncount = 3\n', "count", "beside 'file'", "either"),
    "no file": (HEAD + 'file = "god.npy"\nintensity = 1\n', "file", "no file", "'good.npy'"),
    "another kind": (HEAD + 'file = "model.obj"\nintensity = 1\n', "file", "no file of particles", ".npy"),
    "flat rows": (HEAD + 'file = "flat.npy"\nintensity = 1\n', "file", "the shape (12,)", "rows of x, y, z"),
    "negative": (HEAD + 'file = "negative.npy"\n', "file", "intensities hold -12", "candela from 0"),
    "objects": (HEAD + 'file = "objects.npy"\nintensity = 1\n', "file", "cannot be read", "rows of x, y, z"),
    "other arrays": (HEAD + 'file = "other.npz"\nintensity = 1\n', "file", "no array 'positions'", "rows of"),
    "a bomb": (HEAD + 'file = "bomb.npz"\nintensity = 1\n', "file", "unfolds to more than", "rows of"),
    "text for numbers": (HEAD + 'file = "complex.npz"\nintensity = 1\n', "file", "no array of numbers", "three"),
    "words": (HEAD + 'file = "words.csv"\nintensity = 1\n', "file", "cannot be read", "rows of x, y, z"),
    "cut short": (HEAD + 'file = "cut.npy"\nintensity = 1\n', "file", "cannot be read", "rows of x, y, z"),
    "no archive": (HEAD + 'file = "text.npz"\nintensity = 1\n', "file", "cannot be read", "rows of x, y, z"),
    "a size that is not there": (HEAD + 'file = "huge.npy"\nintensity = 1\n', "file", "cannot be read", "rows of"),
    "half a particle": (HEAD + "count = 1.5\nintensity = 1\n" + BOX, "count", "is 1.5", "whole number"),
    "none": (HEAD + "count = 0\nintensity = 1\n" + BOX, "count", "is 0", "at least 1"),
    "no box": (HEAD + "count = 2\nintensity = 1\n", "box", "is missing", "2 lists of 3"),
    "box upside down": (HEAD + "count = 2\nintensity = 1\nbox = [[0, 0, 0], [1, -1, 1]]\n", "box", "not the lowest",
                        "lower first"),
    "unknown key": (HEAD + "counts = 2\n", "counts", "no such key", "count"),
}  # fmt: skip


@pytest.mark.parametrize("name", MISTAKES)
def test_mistakes_in_toml_are_named_with_place_and_remedy(toml, tmp_path, name):
    files(tmp_path)
    text, key, problem, remedy = MISTAKES[name]
    with pytest.raises(SceneError) as caught:
        toml(text)
    assert caught.value.place == f"[[light]] 1 'sparks': {key}"
    assert problem in str(caught.value) and remedy in str(caught.value)
