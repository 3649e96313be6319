"""Views: what a camera or one face of a light's shadow map sees. All projections are reverse z (1 near, 0 far)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import tan

import numpy as np

from ..scene.cameras import Camera
from ..scene.lights import DirectionalLight, PointLight, SpotLight
from ..simulator.rsm import CUBE_FORWARD, CUBE_RIGHT, CUBE_UP
from .structs import VIEW

# Reverse z keeps a relative precision of 2^-24 at any distance, so a light's near plane may lie very near.
_NEAR_OF_SCENE = 1e-4
CUBE_FACES = len(CUBE_FORWARD)
# The widest cone a single perspective map can hold; wider spots are drawn at this angle (tan would grow without bound).
MAX_HALF_ANGLE = np.radians(85.0)


@dataclass(frozen=True, eq=False)
class View:
    """A view with its axes in world space.

    right, up: half the extent of the picture, per metre of depth for a perspective, in metres otherwise.
    shift: pixels, right and down, by which what is seen through a pixel's centre lies away from it.
    """

    position: np.ndarray
    right: np.ndarray
    up: np.ndarray
    forward: np.ndarray
    near: float
    far: float  # of an orthographic view; a perspective has no far plane
    perspective: bool
    width: int
    height: int
    shift: tuple[float, float] = (0.0, 0.0)

    @property
    def depth_scale(self) -> float:
        """The depth map holds depth_scale / depth in a perspective; else it falls by depth_scale per metre."""
        return self.near if self.perspective else 1.0 / (self.far - self.near)

    @property
    def mirrored(self) -> bool:
        """Whether triangles change their winding in it, as they do in faces of cube maps (simulator/rsm.py)."""
        return bool(np.cross(self.right, self.up) @ self.forward > 0.0)

    @property
    def view_projection(self) -> np.ndarray:
        """World to clip space, float64 (4, 4)."""
        rows = np.zeros((4, 4))
        rows[0, :3] = self.right / (self.right @ self.right)
        rows[1, :3] = self.up / (self.up @ self.up)
        if self.perspective:  # z = near, w = depth: depth 1 at the near plane, 0 at infinity
            rows[3, :3] = self.forward
            rows[:, 3] = -rows[:, :3] @ self.position
            rows[2] = [0.0, 0.0, 0.0, self.near]
            return self._shifted(rows)
        rows[2, :3] = -self.forward * self.depth_scale
        rows[:, 3] = -rows[:, :3] @ self.position
        rows[2, 3] += self.far * self.depth_scale
        rows[3, 3] = 1.0
        return self._shifted(rows)

    def _shifted(self, rows: np.ndarray) -> np.ndarray:
        rows[0] -= 2.0 * self.shift[0] / self.width * rows[3]
        rows[1] += 2.0 * self.shift[1] / self.height * rows[3]
        return rows

    def widened(self) -> View:
        """The view with a pixel more on each side: it holds what every sample of its pixels may see."""
        right, up = self.right * (1.0 + 2.0 / self.width), self.up * (1.0 + 2.0 / self.height)
        return replace(self, right=right, up=up)

    def pack(self, light: int = 0) -> np.ndarray:
        """As the WGSL struct `View`."""
        corner = self.up - self.right  # upper left, half extents
        dx, dy = 2.0 * self.right / self.width, -2.0 * self.up / self.height
        corner = corner + self.shift[0] * dx + self.shift[1] * dy
        zero = np.zeros(3)
        spread = {"direction": self.forward + corner, "direction_dx": dx, "direction_dy": dy}
        shift = {"origin": self.position, "origin_dx": zero, "origin_dy": zero}
        if not self.perspective:
            spread = {"direction": self.forward, "direction_dx": zero, "direction_dy": zero}
            shift = {"origin": self.position + corner, "origin_dx": dx, "origin_dy": dy}
        return VIEW.pack(
            view_projection=self.view_projection.T, size=self.width, perspective=self.perspective, light=light,
            depth_scale=self.depth_scale, **spread, **shift,
        )  # fmt: skip


def camera_view(camera: Camera, width: int, height: int, far: float) -> View:
    """The view of `camera`; `far` bounds an orthographic one (metres from the camera)."""
    rotation = camera.transform[:3, :3]
    perspective = camera.orthographic_height is None
    half = tan(0.5 * camera.vertical_fov) if perspective else 0.5 * float(camera.orthographic_height or 0.0)
    right, up = rotation[:, 0] * half * width / height, rotation[:, 1] * half
    far = max(1.01 * far, 2.0 * camera.near)
    return View(camera.position, right, up, camera.forward, camera.near, far, perspective, width, height)


def _near(bounds: tuple[np.ndarray, np.ndarray]) -> float:
    return max(_NEAR_OF_SCENE * float(np.linalg.norm(bounds[1] - bounds[0])), 1e-6)


def point_views(light: PointLight, bounds: tuple[np.ndarray, np.ndarray], resolution: int) -> list[View]:
    """Six faces of 90 degrees, in the order +x -x +y -y +z -z."""
    position = np.asarray(light.position, dtype=np.float64)
    faces = zip(CUBE_RIGHT, CUBE_UP, CUBE_FORWARD, strict=True)
    near = _near(bounds)
    return [View(position, r, u, f, near, np.inf, True, resolution, resolution) for r, u, f in faces]


def _frame_of(direction: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Right, up, forward for a light that shines along `direction`."""
    forward = direction / np.linalg.norm(direction)
    helper = np.eye(3)[int(np.argmin(np.abs(forward)))]
    right = np.cross(forward, helper)
    right /= np.linalg.norm(right)
    return right, np.cross(right, forward), forward


def spot_views(light: SpotLight, bounds: tuple[np.ndarray, np.ndarray], resolution: int) -> list[View]:
    """One square perspective around the cone."""
    right, up, forward = _frame_of(np.asarray(light.direction, dtype=np.float64))
    half = tan(min(light.outer_angle, MAX_HALF_ANGLE))
    position = np.asarray(light.position, dtype=np.float64)
    return [View(position, right * half, up * half, forward, _near(bounds), np.inf, True, resolution, resolution)]


def directional_views(light: DirectionalLight, bounds: tuple[np.ndarray, np.ndarray], resolution: int) -> list[View]:
    """One orthographic view that just holds the box `bounds`."""
    right, up, forward = _frame_of(np.asarray(light.direction, dtype=np.float64))
    corners = np.array(np.meshgrid(*zip(*bounds, strict=True), indexing="ij")).reshape(3, -1).T
    along = corners @ np.stack([right, up, forward], axis=1)
    low, high = along.min(axis=0), along.max(axis=0)
    # A hair of room, so that what lies on the box's faces is not clipped by rounding: places, and each of the products
    # that a matrix makes of them, have 2^-24 of their distance from the origin.
    hair = max(1e-4 * max(float((high - low).max()), 1e-3), 2.0**-20 * float(np.abs(along).max()))
    half = 0.5 * (high - low) + hair
    centre = 0.5 * (low + high)
    position = right * centre[0] + up * centre[1] + forward * (centre[2] - half[2])
    return [View(position, right * half[0], up * half[1], forward, 0.0, 2.0 * half[2], False, resolution, resolution)]
