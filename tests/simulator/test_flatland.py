"""Flatland: closed forms of light in the plane, what the schemes keep, and what more bands change."""

from __future__ import annotations

from itertools import pairwise
from math import cos, pi, sin

import numpy as np
import pytest

from octolux.scene.errors import OctoluxError
from octolux.simulator.flatland import (
    SCHEMES,
    AreaLight,
    Harmonics,
    Sectors,
    Setting,
    l_shape,
    one_light,
    propagate,
    step,
)  # fmt: skip
from octolux.simulator.flatland.comparison import ANGLES, compare, solve
from octolux.simulator.flatland.figure import flatland_figure
from octolux.simulator.flatland.schemes import DOM4, DOM8, LPV, flux

ROUNDING = 1e-12
BASES = [Harmonics(1), Harmonics(2), Harmonics(5), Harmonics(12), Sectors(4), Sectors(8), Sectors(12)]
EXACT = [scheme for scheme in SCHEMES.values() if scheme.exact]
CIRCLE = 2.0 * pi


def names(values) -> list[str]:
    return [getattr(v, "label", None) or v.name for v in values]


def random_cells(basis, seed: int = 5) -> np.ndarray:
    """Random light in the middle cell of a 7 x 7 grid, so that nothing leaves it in two steps."""
    cells = np.zeros((7, 7, basis.size))
    cells[3, 3] = np.random.default_rng(seed).normal(size=basis.size)
    return cells


def summed(light: AreaLight, point, normal_angle: float | None, parts: int = 20000) -> float:
    """Fluence, or irradiance, of point-like parts: radiance M/2 times the angle dl cos / r that a part fills."""
    ends = light.ends()
    at = ends[0] + (ends[1] - ends[0]) * ((np.arange(parts) + 0.5) / parts)[:, None]
    way = np.asarray(point) - at
    distance = np.linalg.norm(way, axis=1)
    cosine = way @ [cos(light.angle), sin(light.angle)] / distance
    received = 1.0 if normal_angle is None else np.maximum(0, -way @ [cos(normal_angle), sin(normal_angle)] / distance)
    length = np.linalg.norm(ends[1] - ends[0]) / parts
    return float(np.sum(light.exitance / 2.0 * np.maximum(0, cosine) / distance * received) * length)


@pytest.mark.parametrize("setting", [one_light(), l_shape()], ids=lambda s: s.name)
@pytest.mark.parametrize("cell", [(3, 4), (6, 7), (11, 2)])
def test_the_analytic_fluence_and_irradiance_are_those_of_many_small_lights(setting, cell):
    # The midpoint rule's error is at most length^3 / (24 parts^2) times the second derivative, which at a distance of
    # 2 cells or more is below 6 / 2^3 for both integrands: 1e-6 is far above it.
    point = np.array(cell) + 0.5
    assert setting.fluence()[cell[1], cell[0]] == pytest.approx(
        sum(summed(light, point, None) for light in setting.lights), abs=1e-6
    )
    for normal in (pi, 2.0, -2.5, 0.3):
        expected = sum(summed(light, point, normal) for light in setting.lights)
        assert setting.irradiance(point, normal) == pytest.approx(expected, abs=1e-6)


def test_behind_a_light_there_is_none_of_its_light():
    setting = Setting("middle", 8, 5, (AreaLight((4, 1), (4, 3), 0.0),))
    assert not setting.fluence()[:, :5].any()
    assert setting.fluence()[:, 5:].all()


def test_the_analytic_intensity_integrates_to_the_fluence():
    # Radiance is intensity over |cos| + |sin|, constant between two angles: the sum is off by half a step at each end.
    across = np.abs(np.cos(ANGLES)) + np.abs(np.sin(ANGLES))
    spacing = ANGLES[1] - ANGLES[0]
    for setting in (one_light(), l_shape()):
        found = (setting.intensity(ANGLES) / across).sum(axis=-1) * spacing
        free = ~setting.lit()
        assert np.abs(found - setting.fluence())[free].max() <= 0.5 * spacing * len(setting.lights) + ROUNDING


def test_harmonics_are_orthonormal_and_their_integrals_exact():
    basis = Harmonics(9)
    values = basis.evaluate(ANGLES)
    gram = values.T @ values * (CIRCLE / ANGLES.size)  # exact: trigonometric sums of order below 720
    assert np.abs(gram - np.eye(basis.size)).max() < ROUNDING
    # Gauss's rule of 40 points integrates cos(8 t) over an angle of 2 to rounding.
    nodes, weights = np.polynomial.legendre.leggauss(40)
    assert np.abs(basis.integral(0.3, 2.3) - weights @ basis.evaluate(1.3 + nodes)).max() < ROUNDING


@pytest.mark.parametrize("basis", BASES, ids=names(BASES))
@pytest.mark.parametrize("angle", [0.0, 0.7, -2.5])
def test_a_cosine_lobe_is_its_projection(basis, angle):
    whole = basis.integral(0.0, CIRCLE)
    assert basis.cosine_lobe(angle) @ whole == pytest.approx(2.0, abs=ROUNDING)
    assert basis.uniform(angle, angle + 0.9) @ whole == pytest.approx(1.0, abs=ROUNDING)
    nodes, weights = np.polynomial.legendre.leggauss(60)
    if isinstance(basis, Harmonics):
        expected = (weights * pi / 2 * np.cos(pi / 2 * nodes)) @ basis.evaluate(angle + pi / 2 * nodes)
        assert np.abs(basis.cosine_lobe(angle) - expected).max() < ROUNDING
    else:
        fine = (np.arange(100000) + 0.5) * CIRCLE / 100000
        expected = np.maximum(0, np.cos(fine - angle)) @ basis.evaluate(fine) * basis.count / 100000
        # A sector of 2 pi / n that the fine steps cut wrongly by one of them on each side.
        assert np.abs(basis.cosine_lobe(angle) - expected).max() < 2 * basis.count / 100000


@pytest.mark.parametrize("basis", BASES, ids=names(BASES))
@pytest.mark.parametrize("scheme", EXACT, ids=names(EXACT))
def test_a_step_keeps_flux(basis, scheme):
    cells = random_cells(basis)
    assert flux(step(cells, scheme, basis), basis).sum() == pytest.approx(flux(cells, basis).sum(), abs=ROUNDING)


@pytest.mark.parametrize("bands", [1, 2, 3, 4])
def test_faces_read_in_their_middle_keep_flux_up_to_four_bands(bands):
    basis = Harmonics(bands)
    cells = random_cells(basis)
    assert flux(step(cells, LPV, basis), basis).sum() == pytest.approx(flux(cells, basis).sum(), abs=ROUNDING)


def test_from_the_fifth_band_on_they_do_not():
    # cos 4t: eight side faces of angle b read at (a/2 + pi/4) and its mirror images, four far ones of angle a at 0.
    basis = Harmonics(5)
    cells = np.zeros((3, 3, basis.size))
    cells[1, 1, 7] = 1.0
    far, middle = 2.0 * np.arctan(1 / 3), (np.arctan(1 / 3) + pi / 4) / 2
    expected = (4 * far + 8 * (pi / 4 - np.arctan(1 / 3)) * cos(4 * middle)) / np.sqrt(pi)
    assert abs(expected) > 0.1
    assert flux(step(cells, LPV, basis), basis).sum() == pytest.approx(expected, abs=ROUNDING)


@pytest.mark.parametrize(
    ("scheme", "count", "way"), [(DOM4, 4, 0), (DOM4, 4, 3), (DOM8, 8, 2), (DOM8, 8, 1), (DOM8, 8, 5)]
)
def test_ordinates_carry_a_beam_along_its_direction_exactly(scheme, count, way):
    basis = Sectors(count)
    cells = np.zeros((9, 9, count))
    cells[4, 4, way] = 1.5
    dx, dy = round(cos(way * CIRCLE / count)), round(sin(way * CIRCLE / count))
    for k in range(1, 5):
        cells = step(cells, scheme, basis)
        expected = np.zeros_like(cells)
        expected[4 + k * dy, 4 + k * dx, way] = 1.5
        assert np.abs(cells - expected).max() < ROUNDING
    assert np.abs(step(cells, scheme, basis)).max() < ROUNDING  # and leaves the grid


def test_what_crosses_a_cell_is_the_same_along_axes_and_diagonals():
    """A field with the same radiance everywhere: the cell's sum over a step's lengths is that field again."""
    basis = Sectors(8)
    for way in (0, 1):
        cells = np.zeros((15, 15, 8))
        if way == 0:
            cells[:, 0, way] = 1.0  # radiance 1 along +x: flux 1 enters each cell of the left column
        else:
            cells[0, :, way] = cells[:, 0, way] = 1.0
        total, _ = propagate(cells, 14, DOM8, basis)
        inner = total[2:-2, 2:-2, way]
        # Along the axis 1 crosses; along the diagonal each cell is reached once, by light that crosses two.
        assert np.abs(inner - (1.0 if way == 0 else 2.0)).max() < ROUNDING


@pytest.mark.parametrize("scheme", [DOM4, DOM8], ids=lambda s: s.name)
def test_more_bands_bring_discrete_ordinates_nearer_to_plain_ones(scheme):
    """Share of an even sector's light that stays on its way: D/(2 pi) (1 + 2 sum (sin(k D/2) / (k D/2))^2).

    It is 1 for all bands; what B bands lack is below D/pi * sum over k >= B of 4/(k D)^2 <= 4 / (pi D (B - 1)).
    """
    width = CIRCLE / len(scheme.transfers)
    shares = []
    for bands in (2, 4, 8, 16, 32, 64):
        basis = Harmonics(bands)
        k = np.arange(1, bands) * width / 2
        shares.append(float(scheme.weights(basis)[0] @ scheme.lobes(basis)[0]))
        assert shares[-1] == pytest.approx(width / CIRCLE * (1 + 2 * np.sum((np.sin(k) / k) ** 2)), abs=ROUNDING)
        assert 0.0 <= 1.0 - shares[-1] <= 4.0 / (pi * width * (bands - 1))
    assert shares == sorted(shares)


@pytest.mark.parametrize("basis", BASES[:4], ids=names(BASES[:4]))
@pytest.mark.parametrize("scheme", [DOM4, DOM8], ids=lambda s: s.name)
def test_discrete_ordinates_never_grow(scheme, basis):
    """From sector to sector a step is D times the Gram matrix of projected sectors: its eigenvalues are in [0, 1]."""
    between = scheme.weights(basis) @ scheme.lobes(basis).T
    assert np.abs(between - between.T).max() < ROUNDING
    values = np.linalg.eigvalsh(between)
    assert values.min() > -ROUNDING
    assert values.max() < 1.0 + ROUNDING


def test_more_bands_represent_the_analytic_solution_better():
    """Parseval: what a projection lacks falls with each band, and is what the coefficients do not hold."""
    truth = one_light().intensity(ANGLES)[~one_light().lit()]
    norm, errors = float((truth**2).sum()), []
    for bands in (1, 2, 3, 4, 8, 16):
        values = Harmonics(bands).evaluate(ANGLES)
        errors.append(float(((truth @ values * (CIRCLE / ANGLES.size) @ values.T - truth) ** 2).sum()) / norm)
    assert all(a > b for a, b in pairwise(errors))


@pytest.mark.parametrize("scheme", SCHEMES.values(), ids=names(SCHEMES.values()))
def test_one_light_is_mirrored_above_and_below(scheme):
    found = solve(one_light(), scheme, Harmonics(3)).intensity
    assert np.abs(found - found[::-1, :, ::-1]).max() < 1e-9 * np.abs(found).max()


def test_the_findings_of_the_paper():
    """Section 5: with few bands all are alike; with many DOM4 loses the direction to ray effects, LPV does not."""
    rows = {(r.scheme.name, r.basis.label): r.errors() for r in compare((2, 16)) if r.setting.name == "one area light"}
    turned = {key: row["direction_error"] for key, row in rows.items()}
    assert turned["LPV", "2 bands"] < turned["DOM4", "2 bands"]  # light at grazing angles
    assert turned["DOM4", "16 bands"] > 2 * turned["LPV", "16 bands"]
    assert turned["DOM8", "16 bands"] < turned["LPV", "16 bands"]
    assert rows["DOM8", "16 bands"]["relative_rmse"] < rows["LPV", "16 bands"]["relative_rmse"]


@pytest.mark.parametrize("options", [
    {"bands": [0]}, {"bands": []}, {"bands": [2, 2]}, {"bands": [100000]}, {"size": (3, 9)}, {"size": (12, 1000)},
    {"iterations": -1},
])  # fmt: skip
def test_numbers_out_of_range_are_one_clear_error(options):
    with pytest.raises(OctoluxError, match="flatland: "):
        flatland_figure(**options)


def test_lights_that_cannot_be_are_refused():
    with pytest.raises(ValueError, match="row or column"):
        AreaLight((0, 0), (3, 0), 0.0)
    with pytest.raises(ValueError, match="outside"):
        Setting("small", 2, 2, (AreaLight((0, 0), (0, 4), 0.0),))
    with pytest.raises(ValueError, match="negative"):
        propagate(np.zeros((2, 2, 3)), -1, LPV, Harmonics(2))


def test_the_figure_draws_every_scheme_of_every_cell():
    figure, rows = flatland_figure((2,), (6, 5))
    assert len(figure.axes) == 2
    assert len(rows) == 2 * (len(SCHEMES) + 2)
    colours = {line.get_color() for line in figure.axes[0].lines}
    assert {"#2a9134", "#2b59c3", "#d1242f", "black"} <= colours
