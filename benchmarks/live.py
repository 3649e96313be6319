"""Live scenes: what is uploaded when something changes, and whether memory grows over many frames."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import octolux

from .lab import device
from .program import child
from .registry import figure, within
from .scenes_on_disk import SCENES, path_of

FRAMES, EARLY = 500, 50
OCTREE_FRAMES = 2000
SIZE = (64, 36)


@figure("live_uploads", group="live", unit="kB")
def live_uploads() -> dict[str, float]:
    """Bytes written to the device for one frame of the built-in atrium after a change; `first` is the whole scene.

    A frame always writes its views, lights and lists of visible clusters: that is `unchanged`, and in all the others.
    """
    scene = octolux.load("atrium")
    renderer = octolux.Renderer(scene, "none", size=SIZE, device=device())
    start = renderer.device.uploaded_bytes
    renderer.render()
    found = {"first": renderer.device.uploaded_bytes - start}
    changes = {
        "unchanged": lambda: None, "light": _light, "instance": _instance, "material": _material,
        "deformed_mesh": _deformed, "new_mesh": _added,
    }  # fmt: skip
    for name, change in changes.items():
        if name != "unchanged":
            change(scene)
        before = renderer.device.uploaded_bytes
        renderer.render()
        found[name] = renderer.device.uploaded_bytes - before
    found["deformed_mesh_itself"] = 32 * len(scene.meshes[0].positions)
    return {name: size / 1e3 for name, size in found.items()}


def _light(scene: octolux.Scene) -> None:
    scene.lights[0] = replace(scene.lights[0], direction=(0.1, -1.0, 0.3))


def _instance(scene: octolux.Scene) -> None:
    moved = scene.instances[0].transform.copy()
    moved[1, 3] += 0.1
    scene.instances[0] = replace(scene.instances[0], transform=moved)


def _material(scene: octolux.Scene) -> None:
    scene.materials[0] = replace(scene.materials[0], roughness=0.5)


def _deformed(scene: octolux.Scene) -> None:
    mesh = scene.meshes[0]
    scene.meshes[0] = replace(mesh, positions=mesh.positions * np.float32(1.01))


def _added(scene: octolux.Scene) -> None:
    scene.meshes.append(replace(scene.meshes[0], name="copy"))
    scene.instances.append(replace(scene.instances[0], mesh=len(scene.meshes) - 1, name="copy"))


@figure(
    "long_run", group="live",
    unit={"resident_early": "MB", "resident_late": "MB", "resident_growth": "%", "device_growth": "%"},
    bound={"resident_growth": within(0.0, 2.0), "device_growth": within(0.0, 2.0)},
)  # fmt: skip
def long_run() -> dict[str, float]:
    """Memory after 500 frames against that after 50: two moving lamps and a running, skinned fox in the Cornell box."""
    return _growth(child("long_run_child", path_of("moving_fox"), str(FRAMES), str(EARLY)))


@figure(
    "long_run_octree", group="live",
    unit={"resident_early": "MB", "resident_late": "MB", "resident_growth": "%", "device_growth": "%"},
    bound={"resident_growth": within(0.0, 2.0), "device_growth": within(0.0, 2.0)},
)  # fmt: skip
def long_run_octree() -> dict[str, float]:
    """The same of octree-lpv, 2,000 frames against 200: two moving lamps in the Cornell box, 64^2 pixels and RSMs."""
    words = (SCENES / "moving_lamps.toml", str(OCTREE_FRAMES), str(OCTREE_FRAMES // 10), "octree-lpv", "default", "64")
    return _growth(child("long_run_child", *words, seconds=1800.0))


def _growth(found: dict[str, dict[str, float]]) -> dict[str, float]:
    early, late = found["early"], found["late"]
    return {
        "resident_early": early["resident"] / 1e6, "resident_late": late["resident"] / 1e6,
        "resident_growth": 100.0 * (late["resident"] / early["resident"] - 1.0),
        "device_growth": 100.0 * (late["device"] / early["device"] - 1.0),
    }  # fmt: skip
