"""The [[keyframes]] tables of a TOML scene: what of the scene changes over time."""

from __future__ import annotations

from dataclasses import fields
from typing import cast

import numpy as np

from ..motion.tracks import Interpolation, Target, Track
from ..scene import Scene
from .fields import Table, nearest

KINDS: dict[str, Target] = {"light": "light", "camera": "camera", "instance": "instance"}
INTERPOLATIONS = ("linear", "step", "smooth")
INSTANCE_PROPERTIES = {"translation": 3, "rotation": 4, "scale": 3}
CAMERA_PROPERTIES = {"position": 3, "look_at": 3}
LIGHT_PROPERTIES = {"position": 3, "direction": 3, "intensity": 3, "illuminance": 3, "radiance": 3}
"""Names and widths of what may change; a light has those of these that its type has."""

COLORS = ("intensity", "illuminance", "radiance")


def load_track(table: Table, scene: Scene) -> Track:
    """The track that one [[keyframes]] table describes, for an object of `scene`. Raises SceneError."""
    table.allow(("target", "property", "times", "values", "interpolation", "loop"))
    target, name = _target(table, scene)
    widths = _properties(scene, target, name)
    key = table.choice("property", tuple(widths))
    times = _times(table)
    values = _values(table, key, widths[key])
    if len(values) != len(times):
        raise table.error("values", f"has {len(values)} entries for {len(times)} times", "give one value for each time")
    interpolation = cast(Interpolation, table.choice("interpolation", INTERPOLATIONS, "linear"))
    period = float(times[-1]) if table.boolean("loop", False) else None
    if period is not None and period <= 0:
        raise table.error("loop", f"the last time is {period:g}", "give a last time above 0; then it begins again")
    return Track(target=target, name=name, property=key, times=times, values=values, interpolation=interpolation,
                 period=period)  # fmt: skip


def with_clip_first(table: Table, scene: Scene) -> list[Track]:
    """The tracks of `scene`, those of the clip that the table [animation] names before the others, so that it plays.

    Raises SceneError.
    """
    table.allow(("clip",))
    if "clip" not in table:
        return scene.tracks
    clip = table.choice("clip", scene.clips)
    return sorted(scene.tracks, key=lambda track: track.clip != clip)


def _target(table: Table, scene: Scene) -> tuple[Target, str]:
    kind, colon, name = table.text("target").partition(":")
    if not colon or kind not in KINDS:
        raise table.error("target", f"is '{table.values['target']}'",
                          "write light:NAME, camera:NAME or instance:NAME")
    names = [o.name for o in _objects(scene, kind)]
    if name not in names:
        raise table.error("target", f"there is no {kind} '{name}'", nearest(name, filter(None, names)))
    return KINDS[kind], name


def _objects(scene: Scene, kind: str):
    return {"light": scene.lights, "camera": scene.cameras, "instance": scene.instances}[kind]


def _properties(scene: Scene, target: str, name: str) -> dict[str, int]:
    if target == "instance":
        return INSTANCE_PROPERTIES
    if target == "camera":
        return CAMERA_PROPERTIES
    named = [light for light in scene.lights if light.name == name]
    return {key: width for key, width in LIGHT_PROPERTIES.items()
            if all(key in (f.name for f in fields(light)) for light in named)}


def _times(table: Table) -> np.ndarray:
    given = table.values.get("times")
    times = np.array(table.numbers("times", len(given) if isinstance(given, list) else 1))
    if not len(times):
        raise table.error("times", "is empty", "give at least one time in seconds")
    if not (np.diff(times) > 0).all():
        raise table.error("times", "do not increase", "write them in seconds, in order, each one once")
    return times


def _values(table: Table, key: str, width: int) -> np.ndarray:
    values = np.array(table.rows("values", (width,)))
    if key in COLORS and values.min() < 0:
        raise table.error("values", f"hold a negative {key}, {values.min():g}", "give numbers of 0 or more")
    if key == "scale" and not (values > 0).all():
        raise table.error("values", "hold a scale that is not positive", "give numbers above 0")
    lengths = np.linalg.norm(values, axis=1, keepdims=True)
    if key in ("direction", "rotation") and not lengths.all():
        raise table.error("values", f"hold a {key} of length 0", "give vectors of any length above 0")
    return values / lengths if key == "rotation" else values
