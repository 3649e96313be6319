"""The registry of techniques. Adding one is adding a folder and one line here."""

from __future__ import annotations

from .baselines import Constant, NoTechnique
from .lpv.cascaded.technique import CascadedLpv
from .lpv.octree.technique import OctreeLpv
from .lpv.uniform.technique import UniformLpv
from .path_tracer.technique import PathTracer
from .settings import SettingsError, suggest
from .technique import Technique
from .voxel_cones.technique import VoxelCones

TECHNIQUES: dict[str, type[Technique]] = {
    t.name: t for t in (NoTechnique, Constant, UniformLpv, OctreeLpv, CascadedLpv, VoxelCones, PathTracer)
}


def technique_class(name: str) -> type[Technique]:
    """The technique of that name. Raises SettingsError that names the nearest."""
    if name not in TECHNIQUES:
        raise SettingsError(f"There is no technique '{name}'. {suggest(name, TECHNIQUES)}")
    return TECHNIQUES[name]
