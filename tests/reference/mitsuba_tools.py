"""Mitsuba 3 as an independent witness: scenes go to it through the exporter.

Importing this skips the tests of a module when Mitsuba is not installed. The variant is `llvm_ad_rgb` where a fit LLVM
is found (DRJIT_LIBLLVM_PATH, or the package of the extra `reference`), else `scalar_rgb`, which needs none but is slow
with BSDFs written in Python.
"""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from estimators import mean_and_variance

from octolux.export.files import FileFolder
from octolux.export.mitsuba import mitsuba_description
from octolux.scene.cameras import Camera
from octolux.scene.scene import Scene

BATCHES = 16


def _fit_llvm() -> bool:
    """Whether there is an LLVM that Dr.Jit runs with; others, such as Debian 12's 14 and 15, end the process."""
    if "DRJIT_LIBLLVM_PATH" not in os.environ:
        packaged = sorted((Path(sys.prefix) / "lib").glob("libLLVM.so.*"))
        if not packaged:
            return False
        os.environ["DRJIT_LIBLLVM_PATH"] = str(packaged[-1])
    return True


LLVM = _fit_llvm()
mi: Any = pytest.importorskip("mitsuba", reason="Mitsuba is missing: pip install 'octolux[reference]'")
mi.set_variant("llvm_ad_rgb" if LLVM else "scalar_rgb")
if LLVM:
    import octolux_gltf  # noqa: F401  (registers the BSDF)

needs_llvm = pytest.mark.skipif(not LLVM, reason="needs an LLVM for Mitsuba: DRJIT_LIBLLVM_PATH, version 16 or later")

DEPTHS: dict[str, tuple[tuple[int, int], ...]] = {
    "all": ((1, -1),), "direct": ((1, 2),), "first-bounce": ((1, 3), (-1, 2)), "indirect": ((1, -1), (-1, 2)),
}  # fmt: skip
"""Sets of light paths as sums of (sign, max_depth): Mitsuba's depth 2 is direct light, -1 is without end."""


class Witness:
    """A scene in Mitsuba. size: (width, height)."""

    def __init__(self, scene: Scene, camera: Camera, size: tuple[int, int], **changes: Any):
        """changes: of the description's `integrator`, such as hide_emitters."""
        self.scene, self.camera, self.size = scene, camera, size
        with tempfile.TemporaryDirectory() as folder:
            description = mitsuba_description(scene, camera, size, FileFolder(Path(folder) / "files"), exact=LLVM)
            self.integrator = {**description.pop("integrator"), **changes}
            self.loaded = mi.load_dict(as_dict({**description, "integrator": self.integrator}, Path(folder)))

    def render(self, spp: int, seed: int = 0, max_depth: int = -1) -> np.ndarray:
        """float64 (height, width, 3), the mean of `spp` samples a pixel, evenly over its area."""
        integrator = mi.load_dict({**self.integrator, "max_depth": max_depth})
        return np.array(mi.render(self.loaded, integrator=integrator, spp=spp, seed=seed), dtype=np.float64)

    def batches(self, spp: int, seed: int = 0, paths: str = "all", count: int = BATCHES) -> np.ndarray:
        """(count, height, width, 3): independent pictures of spp / count samples a pixel. Where a set of paths is a
        difference, both parts use the same seed: with LLVM they have the same paths, and what is common cancels."""
        each = max(1, spp // count)
        seeds = range(seed * count, (seed + 1) * count)
        return np.stack([sum(sign * self.render(each, n, depth) for sign, depth in DEPTHS[paths]) for n in seeds])

    def centre_rays(self) -> Any:
        """Rays through the pixel centres, row by row, by Mitsuba's sensor: a list in scalar variants."""
        width, height = self.size
        x, y = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
        sensor = self.loaded.sensors()[0]
        if LLVM:
            places = mi.Point2f(mi.Float(x.ravel()), mi.Float(y.ravel()))
            return sensor.sample_ray(0.0, 0.5, places, mi.Point2f(0.5))[0]
        return [sensor.sample_ray(0.0, 0.5, p, [0.5, 0.5])[0] for p in zip(x.ravel(), y.ravel(), strict=True)]

    def seen(self) -> dict[str, np.ndarray]:
        """`position`, `normal` (shading, as the surface has it), (height, width, 3), and `mask` at pixel centres."""
        width, height = self.size
        rays = self.centre_rays()
        if LLVM:
            si = self.loaded.ray_intersect(rays)
            found = [np.array(si.p).T, np.array(si.sh_frame.n).T, np.array(si.is_valid())]
        else:
            hits = [self.loaded.ray_intersect(ray) for ray in rays]
            found = [np.array([h.p for h in hits]), np.array([h.sh_frame.n for h in hits]),
                     np.array([h.is_valid() for h in hits])]  # fmt: skip
        names = ("position", "normal", "mask")
        return {name: a.reshape(height, width, *a.shape[1:]) for name, a in zip(names, found, strict=True)}

    def at_centres(self, max_depth: int = 2, seed: int = 0) -> np.ndarray:
        """float64 (height, width, 3): one sample through each pixel's centre; exact for direct light of points."""
        width, height = self.size
        integrator = mi.load_dict({**self.integrator, "max_depth": max_depth})
        sampler = mi.load_dict({"type": "independent"})
        rays = self.centre_rays()
        if LLVM:
            sampler.seed(seed, width * height)
            radiance = np.array(integrator.sample(self.loaded, sampler, mi.RayDifferential3f(rays))[0]).T
        else:
            sampler.seed(seed)
            radiance = np.array(
                [integrator.sample(self.loaded, sampler, mi.RayDifferential3f(ray))[0] for ray in rays]
            )  # fmt: skip
        return radiance.reshape(height, width, 3).astype(np.float64)


def render_with_mitsuba(
    scene: Scene, camera: Camera, size: tuple[int, int], spp: int, seed: int = 0, paths: str = "all", **integrator: Any
) -> tuple[np.ndarray, np.ndarray]:
    """Mean picture and the variance of that mean, float64 (height, width, 3) each.

    paths: "all", "direct" (with what glows by itself), "first-bounce" or "indirect".  integrator: its other settings,
    such as hide_emitters. The variance comes from BATCHES independent pictures, and so is itself uncertain by a factor
    of about 1 +- sqrt(2 / (BATCHES - 1)) in pixels where their means are normally distributed.
    """
    return mean_and_variance(Witness(scene, camera, size, **integrator).batches(spp, seed, paths))


def as_dict(description: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The description as `mitsuba.load_dict` wants it: Mitsuba's transforms, whole paths."""
    return {key: _as_value(key, value, folder) for key, value in description.items()}


def _as_value(key: str, value: Any, folder: Path) -> Any:
    if isinstance(value, dict):
        return {"type": "rgb", "value": list(value["value"])} if value["type"] == "rgb" else as_dict(value, folder)
    if isinstance(value, np.ndarray):
        return mi.ScalarTransform4f(value)
    if isinstance(value, tuple):
        return list(value)
    return str(folder / value) if key == "filename" else value
