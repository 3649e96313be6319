"""Ambient visibility where it is known: what screen space (simulator/gtao.py) is held against."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .gtao import arc


def visibility_of_horizons(eye, normal, horizons: Callable, slices: int, turn: float = 0.5) -> float:
    """Visibility at one point from horizons that are known: the integral that simulator/gtao.py samples.

    eye, normal: unit (3,), the directions to the eye and of the surface.  horizons: of the unit u (3,) of a slice's
    side and the normal's angle n towards it, the open angle from the sight line on that side, at most pi / 2 + n.
    turn: of the first slice, in steps from one to the next.
    """
    eye, normal = np.asarray(eye, dtype=np.float64), np.asarray(normal, dtype=np.float64)
    across = np.cross(eye, np.eye(3)[np.argmin(np.abs(eye))])
    across /= np.linalg.norm(across)
    whole = visible = 0.0
    for angle in (np.arange(2 * slices) + turn) * np.pi / slices:
        u = np.cos(angle) * across + np.sin(angle) * np.cross(eye, across)
        n, weight = np.arctan2(normal @ u, normal @ eye), np.hypot(normal @ u, normal @ eye)
        whole += weight * float(arc(0.5 * np.pi + n, n))
        visible += weight * float(arc(horizons(u, n), n))
    return visible / whole


def beside_wall(distance, radius) -> np.ndarray:
    """On a floor, at a distance from an endless wall that is less than the radius; no falloff.

    A ray meets the wall within the radius where its component towards the wall exceeds c = distance / radius. Projected
    on the floor (Nusselt), these are the segment of the unit disc beyond c, of area acos c - c sqrt(1 - c^2).
    """
    c = np.minimum(np.asarray(distance, dtype=np.float64) / radius, 1.0)
    return 1.0 - (np.arccos(c) - c * np.sqrt(1.0 - c * c)) / np.pi


def in_groove(angle) -> np.ndarray:
    """On one of two half planes that meet at an angle (radians, pi is flat), with no radius: sin^2(angle / 2).

    The other one hides a lune, from the tangent plane up to pi - angle: (1 - cos) / 2 of the weight.
    """
    return np.sin(0.5 * np.asarray(angle, dtype=np.float64)) ** 2


def in_slot(width, height) -> np.ndarray:
    """In the middle of the floor of an endless slot, with no radius: the sine of the open half angle."""
    return np.asarray(0.5 * width / np.hypot(0.5 * width, height), dtype=np.float64)
