"""Reflective shadow maps: the faces of a cube map, the solid angle of a texel, and the flux of a VPL.

A VPL reflects the light that arrives in its texel: for a point light intensity times the texel's solid angle,
for a directional light illuminance times the texel's area; both times the diffuse albedo of the surface. A light
without falloff brings the same to each square metre across its rays: intensity * 1/m^2 times the area that the texel
covers at the surface, solid angle * distance^2.
"""

from __future__ import annotations

import numpy as np

from octolux.simulator.solid_angles import rectangle_solid_angle

CUBE_FORWARD = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=np.float64)
"""Viewing axis of each cube face, (6, 3): +x -x +y -y +z -z, the layer order of a cube texture."""

CUBE_RIGHT = np.array([[0, 0, -1], [0, 0, 1], [1, 0, 0], [1, 0, 0], [1, 0, 0], [-1, 0, 0]], dtype=np.float64)
"""World direction of growing columns, (6, 3), as every graphics API lays out cube textures (Vulkan specification,
"Cube Map Face Selection"). Here right x up = forward, the mirror image of a camera: triangles change their winding
when drawn into a face."""

CUBE_UP = np.array([[0, 1, 0], [0, 1, 0], [0, 0, -1], [0, 0, 1], [0, 1, 0], [0, 1, 0]], dtype=np.float64)
"""World direction of falling rows (row 0 is at the top), (6, 3)."""

MIN_COSINE = 1.0 / 16.0
"""Below this cosine between a texel's ray and its surface (86.4 degrees) the surface's area is not believed.

A texel whose ray meets a surface at cosine mu claims 1 / mu footprints, and knows only one point of them. Over surfaces
of all orientations mu has the density 2 mu among texels. A bound m loses the integral of 2 (1 - mu / m) over mu < m,
which is m, of a whole of 2: 1/32 of the area here. Without it the mean square, the integral of 2 / mu, is infinite: one
texel on the rim of a sphere may claim any area. With it that is 1 + 2 ln(1/m) = 6.5 footprints squared, and no texel
claims more than 16 times what is seen of it."""


def cube_texel_directions(resolution: int) -> np.ndarray:
    """Unit directions (6, N, N, 3) [face][row][column] through the texel centres of a cube map of `resolution` N."""
    steps = (np.arange(resolution) + 0.5) * 2.0 / resolution - 1.0
    across = steps[None, None, :, None] * CUBE_RIGHT[:, None, None, :]
    down = steps[None, :, None, None] * -CUBE_UP[:, None, None, :]
    directions = CUBE_FORWARD[:, None, None, :] + across + down
    return directions / np.linalg.norm(directions, axis=-1, keepdims=True)


def cube_face_of(directions) -> np.ndarray:
    """Which cube face, int64 (...), each of `directions` (..., 3) meets. Where components tie, z wins over y over x
    (Vulkan specification, "Cube Map Face Selection")."""
    directions = np.asarray(directions, dtype=np.float64)
    axis = 2 - np.argmax(np.abs(directions[..., ::-1]), axis=-1)
    component = np.take_along_axis(directions, axis[..., None], axis=-1)[..., 0]
    return 2 * axis + (component < 0.0)


def cube_texel_position(directions) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Face (...), and horizontal and vertical position (...) in [0, 1] from the face's upper left, that `directions`
    (..., 3) meet."""
    directions = np.asarray(directions, dtype=np.float64)
    face = cube_face_of(directions)

    def along(axes: np.ndarray) -> np.ndarray:
        return np.sum(directions * axes[face], axis=-1)

    depth = along(CUBE_FORWARD)
    return face, 0.5 * (along(CUBE_RIGHT) / depth + 1.0), 0.5 * (1.0 - along(CUBE_UP) / depth)


def texel_solid_angles(resolution: int, tan_half_fov: float = 1.0) -> np.ndarray:
    """Exact solid angles (N, N), sr, of the texels of a square perspective map; 90 degrees is a cube face."""
    edges = np.linspace(-tan_half_fov, tan_half_fov, resolution + 1)
    low, high = edges[:-1], edges[1:]
    return rectangle_solid_angle(low[None, :], high[None, :], low[:, None], high[:, None], 1.0)


def texel_solid_angles_thesis(resolution: int, tan_half_fov: float = 1.0) -> np.ndarray:
    """The approximation 4 cos^3(theta) tan^2(fov/2) / N^2 of Olovsson 2012, 3.3: (N, N), sr.

    theta is the angle between the axis and the texel's centre. It is the midpoint rule for the integral of
    cos^3 over the texel, so its relative error falls with 1 / N^2.
    """
    steps = ((np.arange(resolution) + 0.5) * 2.0 / resolution - 1.0) * tan_half_fov
    cosine = 1.0 / np.sqrt(1.0 + steps[None, :] ** 2 + steps[:, None] ** 2)
    return 4.0 * cosine**3 * tan_half_fov**2 / resolution**2


def vpl_flux_point(albedo, intensity, solid_angle, distance=1.0) -> np.ndarray:
    """Reflected flux (..., 3), W (lm), of texels lit by a point or spot light: albedo * I * Omega (Olovsson 2012, 3.3).

    albedo: (..., 3).  intensity: (..., 3) towards the texel, cd.  solid_angle: (...) of the texel, sr. The cosine at
    the surface is in it already: a slanted surface fills the same solid angle with more area.  distance: (...) of the
    surface from a light without falloff, m.
    """
    covered = np.asarray(solid_angle, dtype=np.float64) * np.square(distance)
    return np.asarray(albedo) * np.asarray(intensity) * covered[..., None]


def vpl_flux_directional(albedo, illuminance, texel_area: float) -> np.ndarray:
    """Reflected flux (..., 3), W (lm), of texels lit by a directional light: albedo * illuminance * area.

    albedo: (..., 3).  illuminance: (3,) on a plane perpendicular to the light, lx.  texel_area: of the injected texel
    in that plane, m^2 (Kaplanyan & Dachsbacher 2010, 3.1: the flux accounts for the area of the texel).
    """
    return np.asarray(albedo, dtype=np.float64) * np.asarray(illuminance, dtype=np.float64) * texel_area


def vpl_area(footprint, cosine) -> np.ndarray:
    """Area (...), m^2, of the surfaces that texels stand for: footprint / cosine, the cosine at least MIN_COSINE.

    footprint: (...), m^2 across the ray at the surface: solid angle * distance^2, or a directional light's texel.
    cosine: (...), of the angle between the ray and the *geometric* normal; either sign.
    """
    return np.asarray(footprint, dtype=np.float64) / np.maximum(np.abs(cosine), MIN_COSINE)
