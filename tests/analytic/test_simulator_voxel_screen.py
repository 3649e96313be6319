"""Ways on the screen (simulator/voxels/screen.py) against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from octolux.scene.cameras import Camera
from octolux.simulator.camera import pixel_rays, seen_at
from octolux.simulator.gtao import Seen
from octolux.simulator.voxels.screen import CLEARANCE, again, jitter, screen_way, steps_of

CAMERAS = {
    "perspective": Camera.look_at((0.4, 1.1, 2.5), (0.0, 0.3, 0.0), vertical_fov=1.0),
    "orthographic": Camera.look_at((0.4, 1.1, 2.5), (0.0, 0.3, 0.0), orthographic_height=2.5),
}
WIDTH, HEIGHT = 60, 40
REACH = 24.0
VOXEL = 0.05


@pytest.fixture(params=CAMERAS)
def camera(request) -> Camera:
    return CAMERAS[request.param]


def corner(camera: Camera) -> Seen:
    """A floor at y = 0, and a wall at z = -0.5."""
    origins, directions = pixel_rays(camera, WIDTH, HEIGHT)
    normals = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    with np.errstate(divide="ignore"):
        along = (np.array([0.0, -0.5]) - origins @ normals.T) / (directions @ normals.T)
    along[along <= 0.0] = np.inf
    first = along.argmin(axis=-1)
    distance = along.min(axis=-1)
    there = np.isfinite(distance)
    depth = np.where(there, np.where(there, distance, 0.0) * (directions @ camera.forward), 0.0)
    facing = np.where(there[..., None], normals[first], 0.0)
    return Seen(camera, depth, facing, facing)


def ways(count: int, up: bool) -> np.ndarray:
    rng = np.random.default_rng(3)
    found = rng.normal(size=(count, 3))
    found[:, 1] = np.abs(found[:, 1]) if up else found[:, 1]
    return found / np.linalg.norm(found, axis=1, keepdims=True)


def test_points_are_seen_where_their_pixels_are(camera):
    origins, directions = pixel_rays(camera, WIDTH, HEIGHT)
    place, depth = seen_at(camera, origins + 1.7 * directions, WIDTH, HEIGHT)
    rows, columns = np.indices((HEIGHT, WIDTH)) + 0.5
    np.testing.assert_allclose(place, np.stack([rows, columns], axis=-1), atol=1e-9)
    np.testing.assert_allclose(depth, 1.7 * directions @ camera.forward)


def test_nothing_is_seen_behind_a_camera():
    behind = CAMERAS["perspective"].position - CAMERAS["perspective"].forward
    np.testing.assert_array_equal(seen_at(CAMERAS["perspective"], behind, WIDTH, HEIGHT)[0], (-1.0, -1.0))


def from_floor(seen: Seen) -> np.ndarray:
    floor = (seen.geometric[..., 1] == 1.0) & (seen.depth > 0.0)
    floor[[0, -1]] = floor[:, [0, -1]] = False
    return seen.positions()[floor] + (0.0, CLEARANCE * VOXEL, 0.0)


def test_walls_are_met_where_they_are(camera):
    """What goes to the wall within reach, and ends in the picture, meets it not before it is there and at most a step
    later; the floor meets nothing of itself, however flat the way."""
    seen = corner(camera)
    start = from_floor(seen)
    towards = ways(len(start), up=True)
    found = screen_way(seen, start, VOXEL * towards, REACH, 0.5)
    with np.errstate(divide="ignore"):
        there = (-0.5 - start[:, 2]) / towards[:, 2] / VOXEL
    shares = ((np.arange(steps_of(REACH)) + 0.5) / steps_of(REACH)) ** 2 * REACH
    place, _ = seen_at(camera, start + VOXEL * REACH * towards, WIDTH, HEIGHT)
    shown = ((place > 1.0) & (place < (HEIGHT - 1, WIDTH - 1))).all(axis=-1)
    high = start[:, 1] + VOXEL * there * towards[:, 1] > 0.15  # not where a pixel shows floor and wall
    sure = shown & high & (there > 0.0) & (there < shares[-1])
    assert sure.sum() > 20 and (shown & (there < 0.0)).sum() > 50
    assert found.met[sure].all() and not found.met[(there < 0.0) | (there > shares[-1])].any()
    later = shares[np.searchsorted(shares, there[sure])]
    np.testing.assert_allclose(found.free[sure], later)
    met = tuple(found.pixel[sure].T)
    np.testing.assert_array_equal(seen.geometric[met], np.tile([0.0, 0.0, 1.0], (sure.sum(), 1)))


def test_what_goes_behind_something_is_not_known(camera):
    """A square before the camera hides what lies behind: ways that come there meet nothing, and are free up to it
    at most."""
    seen = corner(camera)
    start = from_floor(seen)
    hidden = np.zeros((HEIGHT, WIDTH), bool)
    hidden[10:30, 20:40] = True
    facing = np.where(hidden[..., None], -camera.forward, seen.geometric)
    posted = Seen(camera, np.where(hidden, 0.3, seen.depth), facing, facing)
    place, depth = seen_at(camera, start, WIDTH, HEIGHT)
    start = start[~hidden[tuple(np.floor(place).astype(int).T)] & (depth > 1.0)]
    towards = ways(len(start), up=True)
    plain, found = (screen_way(one, start, VOXEL * towards, REACH, 0.5) for one in (seen, posted))
    other = (found.free != plain.free) | (found.met != plain.met)
    assert 10 < other.sum() < 0.5 * len(start)
    assert not found.met[other].any() and (found.free <= plain.free).all()
    ends = np.floor(seen_at(camera, start + VOXEL * found.free[:, None] * towards, WIDTH, HEIGHT)[0]).astype(int)
    inside = ((ends >= 0) & (ends < (HEIGHT, WIDTH))).all(axis=-1)
    assert not hidden[tuple(ends[inside].T)].any()


def test_cones_of_all_phases_look_at_other_places():
    """The shifts of the 256 are spread evenly: no sixteenth of a step has less than half or more than twice its
    share."""
    shifts = [jitter(number, phase) for number in range(16) for phase in range(16)]
    counts = np.histogram(shifts, 16, (0.0, 1.0))[0]
    assert counts.sum() == 256 and counts.min() >= 8 and counts.max() <= 32


def test_what_is_met_is_lit_again():
    """A geometric series of reflections; of the sky, which is not reflected yet where it arrives, one more."""
    found, albedo, sky = np.array([[2.0, 1.0]]), np.array([[0.5, 0.25]]), np.array([[3.0, 0.0]])
    for bounces in (1, 2, 5):
        series = sum(albedo**n for n in range(bounces))
        np.testing.assert_allclose(again(found, albedo, sky, bounces), found * series + sky * (1.0 + albedo * series))
