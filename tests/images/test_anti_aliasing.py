"""Anti-aliasing: samples against exact coverage, FXAA against many samples, and layers that samples leave alone."""

from __future__ import annotations

import numpy as np
import pytest
from gpu_tools import front_camera, scene_of, small_settings

from octolux.frame.anti_aliasing import MAX_SAMPLES, STILL_SAMPLES, sample_shift, samples_of
from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import quad
from octolux.scene.cameras import Camera
from octolux.scene.environment import Environment
from octolux.scene.errors import OctoluxError
from octolux.scene.lights import PointLight
from octolux.scene.load import load_scene
from octolux.scene.materials import Material
from octolux.scene.meshes import Instance

EDGE = 32
FLAT = Camera.look_at((0.0, 0.0, 3.0), (0.0, 0.0, 0.0), orthographic_height=float(EDGE))  # a pixel is a metre
SLOPE = np.array([0.9, 0.4359]) / np.hypot(0.9, 0.4359)  # of the half plane's normal: x right, y up
WHITE = Material(emissive=(1.0, 1.0, 1.0), base_color=(0, 0, 0), specular=0.0, double_sided=True)


@pytest.mark.parametrize(("given", "sequence", "expected"), [
    ("off", False, (1, False)), ("fxaa", False, (1, True)), ("auto", False, (STILL_SAMPLES, False)),
    ("auto", True, (1, True)), (1, False, (1, False)), ("16", True, (16, False)), (MAX_SAMPLES, False, (1024, False)),
])  # fmt: skip
def test_what_can_be_asked_for(given, sequence, expected):
    assert samples_of(given, sequence) == expected


@pytest.mark.parametrize("given", [0, -4, 1025, "msaa", "", "4.0", "1e2", 2.5, None, "²"])
def test_what_cannot(given):
    with pytest.raises(OctoluxError, match="off, fxaa, auto or a number"):
        samples_of(given, False)


def shifts(samples: int) -> np.ndarray:
    return np.array([sample_shift(k, samples) for k in range(samples)])


@pytest.mark.parametrize("samples", [1, 2, 8, 64, 1000])
def test_samples_lie_in_the_pixel_and_the_last_in_its_middle(samples):
    found = shifts(samples)
    assert found.min() >= -0.5 and found.max() < 0.5
    assert tuple(found[-1]) == (0.0, 0.0)
    assert len(np.unique(found, axis=0)) == samples


@pytest.mark.parametrize("samples", [8, 16, 64, 256])
def test_samples_are_even(samples):
    """The share in every box [-1/2, x) x [-1/2, y) is its area. Of a random set the largest error is about 1 / sqrt(N);
    here no more than that of Hammersley's set, (log2(N) / 3 + 13/9) / N (Halton and Zaremba 1969)."""
    at, grid = shifts(samples) + 0.5, np.linspace(0, 1, 129)[1:]
    share = ((at[:, 0, None, None] < grid[:, None]) & (at[:, 1, None, None] < grid)).mean(axis=0)
    assert np.abs(share - grid[:, None] * grid).max() <= (np.log2(samples) / 3 + 13 / 9) / samples


def half_plane(offset: float):
    """What lies below the line SLOPE . p = offset, in the plane z = 0."""
    along = np.array([-SLOPE[1], SLOPE[0]])
    corners = [s * 90 * along + d * SLOPE for s, d in ((-1, -90.0), (-1, offset), (1, offset), (1, -90.0))]
    return quad([(*corner, 0.0) for corner in corners])


def distances() -> np.ndarray:
    """From the line through the middle to the pixels' centres: (EDGE, EDGE)."""
    x = np.arange(EDGE) + 0.5 - EDGE / 2
    return SLOPE[0] * x[None, :] - SLOPE[1] * x[:, None]


def coverage(distance: np.ndarray) -> np.ndarray:
    """The share of unit squares that lies below a line at `distance` above their centres: the integral of a trapezium
    as wide as the square is across the line (two box filters, one after the other)."""
    wide, narrow = np.abs(SLOPE).max(), np.abs(SLOPE).min()

    def ramp(x):  # second integral of a step
        return 0.5 * np.maximum(x, 0.0) ** 2

    a, b = 0.5 * (wide + narrow), 0.5 * (wide - narrow)
    return (ramp(distance + a) - ramp(distance + b) - ramp(distance - b) + ramp(distance - a)) / (wide * narrow)


def edge_picture(device, anti_aliasing, offset=0.3, **rest):
    scene = scene_of([half_plane(offset)], [WHITE], **rest)
    settings = small_settings(sky_lights=0, emitter_lights=0)
    renderer = Renderer(scene, "none", size=(EDGE, EDGE), device=device, anti_aliasing=anti_aliasing,
                        default_light=False, tone_map="none", exposure=float(np.log2(1 / 1.2)),
                        frame_settings=settings)  # fmt: skip
    return renderer.render(FLAT)


@pytest.mark.parametrize("samples", [1, 4, 8, 64])
def test_alpha_of_a_slanted_edge(device, samples):
    """Alpha is the share of the samples below the line, and as near to the exact coverage as these are to the area of
    any such half plane, wherever it passes."""
    picture = edge_picture(device, samples)
    shift = shifts(samples) @ [SLOPE[0], -SLOPE[1]]  # rows run down
    room = 0.3 - distances()[..., None] - shift
    expected, sure = (room > 0).mean(axis=-1), np.abs(room).min(axis=-1) > 2 / 256  # rasterisers snap corners to 1/256
    assert np.array_equal(picture.alpha[sure], expected[sure].astype(np.float32)) and sure.mean() > 0.9
    everywhere = np.linspace(-1, 1, 4001)
    worst = np.abs((everywhere[:, None] > shift).mean(axis=1) - coverage(everywhere)).max()
    assert np.abs(picture.alpha - coverage(0.3 - distances())).max() <= worst + 1 / samples * (~sure).any()
    np.testing.assert_allclose(picture.radiance, np.repeat(picture.alpha[..., None], 3, axis=2), atol=1e-6)


def test_more_samples_are_nearer(device):
    errors = [np.abs(edge_picture(device, n).alpha - coverage(0.3 - distances())).mean() for n in (1, 8, 64)]
    assert errors[0] > 2 * errors[1] > 4 * errors[2]


@pytest.mark.parametrize("height", [None, 2.5], ids=["perspective", "orthographic"])
def test_other_layers_are_those_of_one_sample(device, height):
    """Bit by bit, for all layers but radiance and alpha; also motion, in the second frame."""
    scene = load_scene("cornell-box")
    camera = Camera.look_at((0.0, 1.0, 3.4), (0.1, 1.0, 0.0), orthographic_height=height)
    layers = []
    for samples in (1, 4):
        scene.instances[3] = Instance(3, scene.instances[3].transform, name="short block")
        renderer = Renderer(scene, "uniform-lpv", size=(40, 30), device=device, anti_aliasing=samples,
                            settings={"n": 16}, frame_settings=small_settings())  # fmt: skip
        renderer.render(camera)
        still, moved = scene.instances[3], scene.instances[3].transform.copy()
        moved[:3, 3] += [0.2, 0.1, 0.0]
        scene.instances[3] = Instance(3, moved, name="short block")
        layers.append(renderer.render(camera).layers)
        scene.instances[3] = still
    one, four = layers
    assert one["motion"].any() and not np.array_equal(one["radiance"], four["radiance"])
    for name in one:
        if name not in ("radiance", "alpha"):
            assert np.array_equal(one[name], four[name]), name


def test_samples_are_repeatable(device):
    scene = scene_of([half_plane(0.3)], lights=[PointLight(position=(1, 2, 3), intensity=(5, 5, 5))])
    pair = [Renderer(scene, "none", size=(24, 24), device=device, anti_aliasing=5).render(FLAT) for _ in range(2)]
    assert np.array_equal(pair[0].radiance, pair[1].radiance) and np.array_equal(pair[0].display, pair[1].display)


def test_fxaa_leaves_flat_pictures_alone(device):
    """Even, and with a ramp below its threshold: the same bytes as without."""
    even = scene_of([quad([(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)])],
                    lights=[PointLight(position=(0, 0, 3), intensity=(30, 20, 10))])  # fmt: skip
    pictures = [Renderer(even, "none", size=(EDGE, EDGE), device=device, anti_aliasing=a).render(front_camera(8.0))
                for a in ("off", "fxaa")]  # fmt: skip
    assert len(np.unique(pictures[0].display)) > 10
    assert np.array_equal(pictures[0].display, pictures[1].display)


def test_fxaa_smooths_an_edge(device):
    """Nearer to 64 samples than one sample is, in the mean; radiance and layers are not touched."""
    off, fxaa, many = (edge_picture(device, a) for a in ("off", "fxaa", 64))
    error = [np.abs(p.display.astype(float) - many.display).mean() for p in (off, fxaa)]
    assert 0 < error[1] < 0.75 * error[0]
    assert np.array_equal(off.radiance, fxaa.radiance) and np.array_equal(off.alpha, fxaa.alpha)
    assert np.array_equal(fxaa.display, edge_picture(device, "fxaa").display)
    far = np.abs(distances() - 0.3) > 4  # pixels whose neighbours are all alike
    assert np.array_equal(off.display[far], fxaa.display[far])


def test_samples_of_the_background(device):
    """An even sky is the same for any number of samples, to the roundings of their sum."""
    sky = Environment((3.0, 2.0, 1.0))
    picture = edge_picture(device, 7, environment=sky)
    outside = picture.alpha == 0
    np.testing.assert_allclose(picture.radiance[outside], np.tile(sky.radiance, (outside.sum(), 1)), rtol=7 * 2.0**-23)
