"""GTAO's float64 version against closed forms: its integral by itself, and on depth buffers of planes."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from octolux.scene.cameras import Camera
from octolux.simulator import gtao
from octolux.simulator.gtao import Seen, ambient_visibility, arc, filtered, tile_noise
from octolux.simulator.gtao_closed_forms import beside_wall, in_groove, in_slot, visibility_of_horizons

X, Z = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
EYES = [(0.0, 0.0, 1.0), (-0.5, 0.3, 0.8), (-0.2, -0.9, 0.4), (-0.6, 0.0, 0.1)]


def unit(v) -> np.ndarray:
    return np.asarray(v, dtype=np.float64) / np.linalg.norm(v)


def above(*planes):
    """Horizons of an opening bounded by planes through the point, given by normals into the opening."""

    def horizon(eye):
        return lambda u, n: min(0.5 * np.pi + np.arctan2(q @ u, q @ eye) for q in planes)

    return horizon


# Midpoint rule over a period, of a function whose derivative has total variation v: the error is at most h^2 v / 8 over
# the period. The arcs change by less than 1 a radian of the horizon, and a horizon by less than 1 / sin(the eye's least
# angle from it) a radian of turn, of which the eyes above keep 0.1: v is below 4 turns of 10 each, up and down: 80.
SLICES = 2000
QUADRATURE = (np.pi / SLICES) ** 2 * 80 / 8


def test_the_integral_of_an_arc():
    horizons, normals = np.linspace(0.0, np.pi, 9), np.linspace(-1.4, 1.4, 7)
    middle, width = (np.arange(4000) + 0.5) / 4000, horizons[:, None, None] / 4000
    t = middle * horizons[:, None, None]
    summed = (np.cos(t - normals[:, None]) * np.sin(t) * width).sum(axis=-1)
    # Midpoint rule: h^2 / 24 times the length and the second derivative, which is at most 4 for a product of sines.
    np.testing.assert_allclose(arc(horizons[:, None], normals), summed, atol=np.pi**3 / 4000**2 / 24 * 4)


@pytest.mark.parametrize("eye", EYES)
def test_open_plane(eye):
    """Exact with any number of slices, and whatever the shading normal: the same arcs stand above and below."""
    eye = unit(eye)
    assert visibility_of_horizons(eye, Z, above(Z)(eye), 3) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("eye", EYES)
@pytest.mark.parametrize("degrees", [20.0, 60.0, 90.0, 150.0])
def test_groove(eye, degrees):
    angle = np.radians(degrees)
    wall = np.array([-np.sin(angle), 0.0, -np.cos(angle)])
    eye = unit(eye) if wall @ unit(eye) > 0.1 else unit(0.5 * (wall + Z))
    found = visibility_of_horizons(eye, Z, above(Z, wall)(eye), SLICES)
    assert found == pytest.approx(in_groove(angle), abs=QUADRATURE)


@pytest.mark.parametrize("height", [0.2, 1.0, 4.0])
def test_slot(height):
    width = 0.8
    walls = [unit((sign * height, 0.0, 0.5 * width)) for sign in (-1.0, 1.0)]
    found = visibility_of_horizons(Z, Z, above(Z, *walls)(Z), SLICES)
    assert found == pytest.approx(in_slot(width, height), abs=QUADRATURE)


def wall_within(radius: float, distance: float, eye: np.ndarray):
    """Horizons at a wall x = distance: in a slice x is A cos t + B sin t, and meets distance / radius first at
    atan2(B, A) less the arc cosine."""

    def horizon(u, n):
        length = np.hypot(X @ u, X @ eye)
        first = np.arctan2(X @ u, X @ eye) - np.arccos(min(distance / radius / length, 1.0))
        limit = 0.5 * np.pi + n
        return min(limit, first) if distance < radius * length and first > 0.0 else limit

    return horizon


@pytest.mark.parametrize("eye", [Z, unit((-1.0, 0.0, 1.0))])
@pytest.mark.parametrize("distance", [0.01, 0.3, 0.8, 1.0])
def test_wall_within_a_radius(eye, distance):
    """From these eyes each slice that enters the blocked cap meets the floor within it: the cap is a height field."""
    found = visibility_of_horizons(eye, Z, wall_within(1.0, distance, eye), SLICES)
    assert found == pytest.approx(beside_wall(distance, 1.0), abs=QUADRATURE)


def test_closed_forms_meet():
    assert beside_wall(0.0, 1.0) == pytest.approx(in_groove(0.5 * np.pi))
    assert in_groove(np.pi) == beside_wall(2.0, 1.0) == 1.0


def seen_planes(camera: Camera, size: tuple[int, int], *planes) -> Seen:
    """The nearest of `planes`, each a normal, a point, and whether a point is within, as `camera` sees them."""
    width, height = size
    nothing = Seen(camera, np.ones((height, width)), *(np.zeros((height, width, 3)),) * 2)
    origins, directions = nothing.rays()
    depth, normals = np.full((height, width), np.inf), np.zeros((height, width, 3))
    for normal, point, within in planes:
        with np.errstate(divide="ignore", invalid="ignore"):
            t = np.sum((np.asarray(point) - origins) * normal, axis=-1) / np.sum(directions * normal, axis=-1)
        hit = origins + np.where(np.isfinite(t), t, 0.0)[..., None] * directions
        nearer = np.isfinite(t) & (t > 0.0) & (t < depth) & within(hit)
        depth, normals = np.where(nearer, t, depth), np.where(nearer[..., None], normal, normals)
    return Seen(camera, np.where(np.isfinite(depth), depth, 0.0), normals, normals)


def everywhere(p):
    return np.ones(p.shape[:-1], bool)


@pytest.mark.parametrize("slant", [0.0, 40.0, 80.0, 89.0])
@pytest.mark.parametrize("kind", [{"vertical_fov": 1.2}, {"orthographic_height": 2.0}])
def test_plane_in_a_depth_buffer(slant, kind):
    """Its samples' heights are zero but for rounding, which is squared in the arcs' ends."""
    a = np.radians(slant)
    camera = Camera.look_at((0.0, 3.0 * np.sin(a), 3.0 * np.cos(a)), (0.0, 0.0, 0.0), **kind)
    seen = seen_planes(camera, (40, 24), (Z, (0.0, 0.0, 0.0), everywhere))
    found, _ = ambient_visibility(seen, 0.7, 3, 6)
    assert np.abs(found - 1.0).max() < 1e-9
    assert np.abs(filtered(seen, found) - 1.0).max() < 1e-9


STEPS, RADIUS = 48, 0.5


@pytest.fixture(scope="module")
def corner() -> SimpleNamespace:
    """Floor z = 0 and wall x = 0 seen at 45 degrees to both, orthographically: a metre has 80 pixels."""
    camera = Camera.look_at((-3.0, 0.0, 3.0), (0.0, 0.0, 0.0), up=(0.0, 1.0, 0.0), orthographic_height=1.5)
    size = (180, 120)
    floor, wall = (Z, (0.0, 0.0, 0.0), lambda p: p[..., 0] < 0.0), (-X, (0.0, 0.0, 0.0), lambda p: p[..., 2] >= 0.0)
    seen = seen_planes(camera, size, floor, wall)
    found, _ = ambient_visibility(seen, RADIUS, 16, STEPS, falloff=0.0)
    return SimpleNamespace(seen=seen, found=found, pixel=1.5 / 120)


def test_wall_in_a_depth_buffer(corner):
    """Samples of one side lie apart, on planes at 45 degrees, by at most `apart`: sqrt 2 times their distance in the
    picture, where each is moved to its pixel's centre by 0.71 pixels. So the highest lies on the wall (or on a chord
    from floor to wall) like one at a distance less by at most that, or within a radius less by at most that."""
    p = corner.seen.positions()
    # Up to where the whole radius is in the picture.
    floor = (corner.seen.geometric @ Z > 0.5) & (np.abs(p[..., 1]) < 0.2) & (p[..., 0] > -0.45)
    distance = -p[..., 0][floor]
    apart = np.sqrt(2.0) * (RADIUS / STEPS + 1.42 * corner.pixel)
    eye = unit((-1.0, 0.0, 1.0))
    turns = (np.arange(16) + 0.5) / 16
    known = [[visibility_of_horizons(eye, Z, wall_within(1.0, d, eye), 16, t) for t in turns] for d in (0.1, 0.5, 0.9)]
    slices = np.abs(np.array(known) - beside_wall(np.array([[0.1], [0.5], [0.9]]), 1.0)).max()
    assert slices < 0.01
    found = corner.found[floor]
    assert floor.sum() > 500
    assert np.all(found >= beside_wall(np.maximum(distance - apart, 0.0), RADIUS) - slices)
    assert np.all(found <= beside_wall(distance + 1.42 * corner.pixel, RADIUS - apart) + slices)


def test_filter_keeps_what_it_means(corner):
    """The mean over a tile of noise is that of sixteen times the slices: nearer to the closed form than one pixel's."""
    p, few = corner.seen.positions(), ambient_visibility(corner.seen, RADIUS, 2, STEPS, falloff=0.0)[0]
    floor = (corner.seen.geometric @ Z > 0.5) & (np.abs(p[..., 1]) < 0.2) & (p[..., 0] > -0.45) & (p[..., 0] < -0.05)
    expected = beside_wall(-p[..., 0][floor], RADIUS)
    raw = np.abs(few[floor] - expected).mean()
    assert np.abs(filtered(corner.seen, few)[floor] - expected).mean() < 0.5 * raw


def test_slot_in_a_depth_buffer():
    """Seen from above its walls are hidden, their upper edges are not: the first sample beyond an edge lies at most a
    step and 0.71 pixels outside. Where a slice runs so far along the slot that the edge is beyond the radius, at most
    (height / radius)^2 is missed, in 2 / pi asin of the width over twice the radius of the slices."""
    width, height, radius, steps, pixel = 0.6, 0.4, 1.4, 64, 3.0 / 121
    camera = Camera.look_at((0.0, 0.0, 3.0), (0.0, 0.0, 0.0), up=(0.0, 1.0, 0.0), orthographic_height=3.0)
    top = (Z, (0.0, 0.0, height), lambda p: np.abs(p[..., 0]) > 0.5 * width)
    seen = seen_planes(camera, (121, 121), top, (Z, (0.0, 0.0, 0.0), everywhere))
    middle = ambient_visibility(seen, radius, 16, steps, falloff=0.0, noise=False)[0][60, 60]
    wider = width + 2.0 * (radius / steps + 0.71 * pixel)
    level = np.sqrt(radius**2 - height**2)
    missed = 2.0 / np.pi * np.arcsin(0.5 * wider / level) * (height / radius) ** 2
    # 16 slices: the horizon's sine turns smoothly, and the midpoint rule errs by h^2 / 8 of its slope's variation, 4.
    slices = (np.pi / 16) ** 2 / 8 * 4 / np.pi
    assert in_slot(width - 1.42 * pixel, height) - slices <= middle <= in_slot(wider, height) + missed + slices


@pytest.mark.parametrize("kind", [{"vertical_fov": 1.8}, {"orthographic_height": 2.0}])
def test_steps_stay_in_the_slice(kind):
    """Also far from the picture's centre, where a perspective stretches angles: what a slice's pixels see, at any
    depth, lies in the plane of the sight line and u, on the side of u."""
    camera = Camera.look_at((1.0, 2.0, 3.0), (0.0, 0.0, 0.0), **kind)
    seen = seen_planes(camera, (31, 21), (unit((1.0, 2.0, 3.0)), (0.0, 0.0, 0.0), everywhere))
    (origins, directions), (right, down) = seen.rays(), seen.pixel_extent()
    eye, positions = -directions / np.linalg.norm(directions, axis=-1, keepdims=True), seen.positions()
    u = np.cross(eye, unit((0.3, -0.5, 0.8)))
    u /= np.linalg.norm(u, axis=-1, keepdims=True)
    side = np.cross(eye, u)
    step = gtao.pixel_step(u, side, right, down)
    np.testing.assert_allclose(np.linalg.norm(step, axis=-1), 1.0, atol=1e-12)
    origin_steps, direction_steps = (np.stack([a[0, 1] - a[0, 0], a[1, 0] - a[0, 0]]) for a in (origins, directions))
    for pixels, depth in [(1.0, 2.0), (4.0, 5.0)]:
        sample = origins + pixels * step @ origin_steps + depth * (directions + pixels * step @ direction_steps)
        assert np.abs(np.sum((sample - positions) * side, axis=-1)).max() < 1e-9
        assert np.sum((sample - positions) * u, axis=-1).min() > 0.0


def test_noise_is_stratified():
    """Each window of a tile's size holds every sixteenth of each of the three once, wherever it lies."""
    noise = tile_noise(*np.indices((11, 9)))
    for y, x in [(0, 0), (3, 2), (7, 5)]:
        window = noise[y : y + gtao.TILE, x : x + gtao.TILE].reshape(-1, 3)
        assert np.array_equal(np.sort(window, axis=0), np.repeat((np.arange(16) + 0.5) / 16, 3).reshape(16, 3))


def test_nothing_seen():
    camera = Camera.look_at((0.0, 0.0, 3.0), (0.0, 0.0, 0.0), up=(0.0, 1.0, 0.0))
    seen = seen_planes(camera, (12, 8), (Z, (0.0, 0.0, 0.0), lambda p: p[..., 0] < 0.0))
    found, _ = ambient_visibility(seen, 0.5, 3, 6)
    assert (seen.depth == 0.0).any()
    assert np.abs(found - 1.0).max() < 1e-9
    assert np.abs(filtered(seen, found) - 1.0).max() < 1e-9
