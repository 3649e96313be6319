"""Tangents against the reference implementation, mikktspace.c, and against closed forms."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from octolux.scene.geometry import mikktspace
from octolux.scene.gltf.loader import load_gltf
from octolux.scene.obj.loader import load_obj

# What mikktspace.c (as in pymikktspace 0.3.0) gives for meshes of 9 x 9 vertices, v turned over. Coordinates are
# multiples of 1/16 and 1/64, so that areas in uv space are exact in single precision and have the same sign here.
REFERENCE = Path(__file__).parent / "data" / "mikktspace.npz"
CASES = ("scattered", "both_windings", "flat_in_uv", "mirrored", "degenerate", "non_manifold")
# The reference computes in float32, with some ten roundings of 6e-8, on sums that cancel to a hundredth of their terms.
TOLERANCE = 1e-4


def case(name: str) -> dict[str, np.ndarray]:
    with np.load(REFERENCE) as stored:
        return {key.partition("/")[2]: stored[key] for key in stored.files if key.startswith(f"{name}/")}


def check(space: mikktspace.TangentSpace, normals: np.ndarray, indices: np.ndarray) -> None:
    """What holds of every answer."""
    count = len(normals)
    assert np.array_equal(space.vertices[:count], np.arange(count))
    assert np.array_equal(space.vertices[space.indices], indices)
    np.testing.assert_allclose(np.linalg.norm(space.tangents[:, :3], axis=1), 1, atol=1e-6)
    np.testing.assert_allclose(np.sum(space.tangents[:, :3] * normals[space.vertices], axis=1), 0, atol=1e-6)
    assert set(np.unique(space.tangents[:, 3])) <= {-1.0, 1.0}


@pytest.mark.covers("glTF generated tangents", files=["tests/scene/data/mikktspace.npz"])
@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("welded", [True, False])
def test_like_the_reference(name, welded):
    mesh = case(name)
    arrays = [mesh["positions"], mesh["normals"], mesh["uvs"]]
    indices = mesh["indices"].astype(np.uint32)
    if not welded:
        arrays = [array[indices.ravel()] for array in arrays]
        indices = np.arange(indices.size, dtype=np.uint32).reshape(-1, 3)
    space = mikktspace.generate(*arrays, indices)
    check(space, arrays[1], indices)
    found, expected = space.tangents[space.indices.ravel()], mesh["tangents"]
    given_up = (expected == (1, 0, 0, -1)).all(axis=1)  # what the reference says of corners without any tangent
    assert given_up.sum() == (32 if name == "flat_in_uv" else 0)
    np.testing.assert_allclose(found[~given_up], expected[~given_up], atol=TOLERANCE)


def plane(size: int = 3) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """A square in the xy plane, its picture upright: u along x, v against y."""
    x, y = (axis.ravel().astype(np.float32) for axis in np.meshgrid(np.arange(size), np.arange(size)))
    positions = np.column_stack([x, y, np.zeros_like(x)])
    normals = np.broadcast_to(np.float32([0, 0, 1]), positions.shape)
    first = (np.arange(size - 1)[:, None] * size + np.arange(size - 1)).ravel()
    lower, upper = [first, first + 1, first + size], [first + 1, first + size + 1, first + size]
    indices = np.concatenate([np.column_stack(lower), np.column_stack(upper)]).astype(np.uint32)
    return positions, normals, np.column_stack([x, -y]), indices


def test_an_upright_plane_keeps_its_vertices():
    space = mikktspace.generate(*plane())
    np.testing.assert_allclose(space.tangents, [[1, 0, 0, 1]] * 9, atol=1e-7)


def test_a_mirrored_seam_is_split():
    positions, normals, uvs, indices = plane()
    uvs = np.column_stack([np.abs(uvs[:, 0] - 1), uvs[:, 1]])  # u falls to the column in the middle, then rises
    space = mikktspace.generate(positions, normals, uvs, indices)
    assert sorted(space.vertices[9:].tolist()) == [1, 4, 7]
    expected = np.where((positions[indices].mean(axis=1)[:, :1] < 1), [[-1, 0, 0, -1]], [[1, 0, 0, 1]])
    np.testing.assert_allclose(space.tangents[space.indices], np.repeat(expected[:, None], 3, axis=1), atol=1e-7)


def test_tangents_of_a_sphere_run_along_its_parallels():
    """Seen from outside u runs east; chords are as near to the parallels as the square of the angle that they span."""
    rows, columns = 32, 64
    v, u = (axis.ravel() for axis in np.mgrid[0 : rows + 1, 0 : columns + 1])
    polar, around = np.pi * v / rows, 2 * np.pi * u / columns
    sphere = np.column_stack([np.sin(polar) * np.cos(around), np.cos(polar), -np.sin(polar) * np.sin(around)])
    first = (np.arange(1, rows - 1)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    below = first + columns + 1
    indices = np.concatenate(
        [np.column_stack([first, below, below + 1]), np.column_stack([first, below + 1, first + 1])]
    )
    points, uvs = sphere.astype(np.float32), np.column_stack([u / columns, v / rows]).astype(np.float32)
    space = mikktspace.generate(points, points, uvs, indices.astype(np.uint32))
    used = np.unique(space.indices)
    east = np.column_stack([-np.sin(around), np.zeros(len(u)), -np.cos(around)])[space.vertices[used]]
    inner = (u[used] > 0) & (u[used] < columns) & (v[used] > 1) & (v[used] < rows - 1)
    np.testing.assert_allclose(space.tangents[used, :3][inner], east[inner], atol=(2 * np.pi / columns) ** 2)
    assert (space.tangents[used, 3] == 1).all()


def test_angles_are_the_weights():
    """Two triangles in a plane: 45 degrees at vertex 0 with (u, v) = (x, -y), so that u rises along (1, 0) where v is
    constant; and 90 degrees with (2 x - y, -x), where it rises along (0, -1)."""
    positions = np.float32([[0, 0, 0], [1, 0, 0], [1, 1, 0], [-1, 1, 0]])
    normals = np.broadcast_to(np.float32([0, 0, 1]), positions.shape)
    uvs = np.float32([[0, 0], [1, 0], [1, -1], [-3, 1]])
    space = mikktspace.generate(positions, normals, uvs, np.uint32([[0, 1, 2], [0, 2, 3]]))
    assert len(space.vertices) == 4
    np.testing.assert_allclose(space.tangents[0], [1 / 5**0.5, -2 / 5**0.5, 0, 1], atol=1e-6)


def test_without_uvs_any_direction_across_the_normal():
    positions, normals, uvs, indices = plane()
    space = mikktspace.generate(positions, normals, np.zeros_like(uvs), indices)
    check(space, normals, indices)
    assert (space.tangents[:, 3] == 1).all()
    nothing = mikktspace.generate(positions, normals, uvs, np.zeros((2, 3), np.uint32))  # all corners at one place
    check(nothing, normals, np.zeros((2, 3), np.uint32))


@pytest.mark.covers("glTF generated tangents", "model .obj")
def test_gltf_and_obj_use_it_where_a_normal_map_is(gltf, picture, tmp_path):
    positions, normals, uvs, indices = plane()
    uvs = np.column_stack([np.abs(uvs[:, 0] - 1), uvs[:, 1]])
    attributes = {"POSITION": gltf.add(positions), "NORMAL": gltf.add(np.array(normals)), "TEXCOORD_0": gltf.add(uvs)}
    attributes["COLOR_0"] = gltf.add(np.linspace(0, 1, 36, dtype=np.float32).reshape(9, 4))
    primitive = {"attributes": attributes, "indices": gltf.add(indices.ravel())}
    picture("normal.png", (128, 128, 255))
    gltf.json |= {
        "images": [{"uri": "normal.png"}],
        "textures": [{"source": 0}],
        "materials": [{"normalTexture": {"index": 0}}, {}],
        "meshes": [{"primitives": [primitive | {"material": 0}, primitive | {"material": 1}]}],
        "nodes": [{"mesh": 0}],
    }
    split, plain = load_gltf(gltf.write()).meshes
    space = mikktspace.generate(positions, normals, uvs, indices)
    assert (len(split.positions), len(plain.positions)) == (12, 9)
    np.testing.assert_array_equal(split.tangents, space.tangents)
    np.testing.assert_array_equal(split.colors, plain.colors[space.vertices])

    lines = [f"v {x} {y} {z}" for x, y, z in positions] + [f"vt {u} {1 - v}" for u, v in uvs] + ["vn 0 0 1"]
    lines += ["f " + " ".join(f"{i}/{i}/1" for i in triangle) for triangle in indices + 1]
    (tmp_path / "a.mtl").write_text("newmtl a\nnorm normal.png\n")
    (tmp_path / "a.obj").write_text("\n".join(["mtllib a.mtl", *lines[:19], "usemtl a", *lines[19:]]))
    mesh = load_obj(tmp_path / "a.obj").meshes[0]
    assert len(mesh.positions) == 12
    corners = [tangents[indices.ravel()] for tangents, indices in ((mesh.tangents, mesh.indices),
                                                                   (space.tangents, space.indices))]  # fmt: skip
    assert sorted(map(tuple, corners[0])) == sorted(map(tuple, corners[1]))
