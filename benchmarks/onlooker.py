"""Light at points that stay, from a light cache that follows another camera: what a moving viewer makes of a scene."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from unittest.mock import patch

import numpy as np

from octolux.compare.choices import choice
from octolux.frame.frame import Frame, FrameSettings
from octolux.frame.views import camera_view
from octolux.picture import Picture
from octolux.renderer import Renderer
from octolux.scene.cameras import Camera
from octolux.scene.scene import Scene
from octolux.techniques.lpv.gathering.gathering import Gathering

from .lab import device

SIZE = (320, 180)
_IN_PLANE = 0.002
"""Metres a metre of distance: surfaces that the viewer sees so near a point's plane are the point's own."""


@dataclass(frozen=True, eq=False)
class Points:
    """What the onlooker sees: places and unit normals (shading and geometric) of surfaces, (count, 3) each."""

    places: np.ndarray
    normals: np.ndarray
    geometric: np.ndarray


class Onlooker:
    """Reads a technique's light at the pixels of `eye`, which stays, after the frame of a viewer who moves.

    The light cache is the viewer's in all: cascades lie around the viewer, and the viewer's G-buffer gives surfels. So
    the light at a point is what the viewer sees there, and no picture has to be resampled; but for what is done in
    screen space, which is the onlooker's. Where it matters which cells are filled, those are that the viewer's pixels
    look up; where it does not (`Gathering.corners`), the onlooker's are besides, as its pixels lie elsewhere. Points
    that the viewer does not see are said so.
    """

    def __init__(
        self, scene: Scene, text: str, eye: Camera, size: tuple[int, int] = SIZE, maps: FrameSettings | None = None
    ):
        one = choice(text)
        self.eye = eye
        self.renderer = Renderer(
            scene, one.technique, settings=one.settings, size=size, exposure=0.0, device=device(), frame_settings=maps
        )
        self.technique = self.renderer.technique
        picture = Renderer(scene, "none", size=size, exposure=0.0, device=device(), frame_settings=maps).render(eye)
        self._mask, layers = picture.mask, picture.layers
        chosen = (layers["position"], layers["normal"], picture.geometric_normal)
        self.points = Points(*(layer[self._mask].astype(np.float64) for layer in chosen))

    def light(self, viewer: Camera, scene: Scene | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Irradiance at the points, mean of the channels, lx, and whether the viewer sees them: (count,) each.

        scene: what is there from now on. What it has moved must not be seen by the eye: its points are the first
        scene's.
        """
        if scene is not None:
            self.renderer.scene = scene
        with _watched(self.renderer) as frames:
            picture = self.renderer.render(viewer)
        with _shading_alone(self.renderer, frames[0]):
            read = self.renderer.render(self.eye).layers["irradiance"]
        return read[self._mask].mean(axis=-1, dtype=np.float64), seen_by(self.points, viewer, picture)


def seen_by(points: Points, viewer: Camera, picture: Picture) -> np.ndarray:
    """Whether the four pixels around each point's place in the viewer's picture show the point's plane: bool (count,).
    Nothing is read between surfaces then, and the cells around the point have been asked for."""
    height, width = picture.mask.shape
    view = camera_view(viewer, width, height, 1.0)
    clip = np.concatenate([points.places, np.ones((len(points.places), 1))], axis=1) @ view.view_projection.T
    depth = np.maximum(clip[:, 3], view.near)
    column = (0.5 + 0.5 * clip[:, 0] / depth) * width - 0.5
    row = (0.5 - 0.5 * clip[:, 1] / depth) * height - 0.5
    left, top = np.floor(column).astype(int), np.floor(row).astype(int)
    seen = (clip[:, 3] > view.near) & (left >= 0) & (top >= 0) & (left < width - 1) & (top < height - 1)
    left, top = np.where(seen, left, 0), np.where(seen, top, 0)
    places, mask = picture.layers["position"], picture.mask
    for y in (0, 1):
        for x in (0, 1):
            away = np.abs(((places[top + y, left + x] - points.places) * points.geometric).sum(axis=-1))
            seen &= mask[top + y, left + x] & (away < _IN_PLANE * depth)
    return seen


@contextmanager
def _watched(renderer: Renderer) -> Iterator[list[Frame]]:
    """The frames that the technique is given."""
    frames: list[Frame] = []
    update = renderer.technique.update

    def watched(frame: Frame) -> None:
        frames.append(frame)
        update(frame)

    with patch.object(renderer.technique, "update", watched):
        yield frames


@contextmanager
def _shading_alone(renderer: Renderer, before: Frame) -> Iterator[None]:
    """Frames for which the technique shades from the cache as `before` left it: it fills no cells, but as `Onlooker`
    says, and no RSM is drawn, as nothing would read it."""
    technique = renderer.technique

    def prepare(frame: Frame) -> None:
        frame.irradiance, frame.specular = before.irradiance, before.specular

    def nothing(*_: object, **__: object) -> None:
        pass

    def without_who_asks(method: Callable[..., None]) -> Callable[..., None]:
        return lambda gathering, *given: method(gathering, *given) if gathering.corners else None

    alone = patch.multiple(technique, prepare=prepare, update=nothing, needs=frozenset())
    asking = {name: without_who_asks(getattr(Gathering, name)) for name in ("mark", "gather")}
    with alone, patch.multiple(Gathering, **asking):
        yield
