"""glTF meshes: each primitive made of triangles becomes one Mesh."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..geometry import triangles as geometry
from ..geometry.tangents import tangent_space
from ..meshes import Mesh
from .accessors import Accessors, require
from .deformables import Movers, read_movers
from .draco import decompressed
from .extensions import UvUse
from .json import Fields

_TRIANGLES, _STRIP, _FAN = 4, 5, 6
# A device's largest buffer holds four million (128 MiB at 32 bytes each). Any number of primitives may show the same
# accessors, so that without a bound a file of a kilobyte could ask for all memory.
_MOST_VERTICES = 1 << 23
_LEFT_OUT = {0: "points", 1: "lines", 2: "lines", 3: "lines"}


@dataclass
class MeshTable:
    """The meshes of a file, in the pose they were modelled in.

    parts[i]: the indices into `meshes` of the primitives of the file's mesh i.  targets[i]: how many morph targets it
    has.  fields[i]: its JSON.
    """

    meshes: list[Mesh] = field(default_factory=list)
    parts: list[list[int]] = field(default_factory=list)
    targets: list[int] = field(default_factory=list)
    fields: list[Fields] = field(default_factory=list)
    empty: list[str] = field(default_factory=list)  # places of primitives in which no triangle has an area
    vertices: int = 0  # so far, those of morph targets included

    def take(self, primitive: Fields, vertices: int) -> None:
        """Count the vertices that a primitive is about to become. Raises SceneError when there are too many."""
        self.vertices += vertices * (1 + self.targets[-1])
        if self.vertices > _MOST_VERTICES:
            problem = f"with it the file has {self.vertices} vertices, more than {_MOST_VERTICES}"
            raise primitive.error(problem, "split the model, or make it coarser")


def read_meshes(root: Fields, accessors: Accessors, uv_uses: list[UvUse], warnings: list[str]) -> MeshTable:
    """Read all meshes of a file.

    uv_uses: for each material, what its textures do with TEXCOORD sets. Primitives of points, of lines, or without area
    are left out and noted in `warnings`. Raises SceneError.
    """
    table = MeshTable()
    for fields in root.children("meshes", "mesh"):
        primitives = fields.children("primitives", "primitive")
        if not primitives:
            raise fields.error("it has no primitives")
        table.parts.append([])
        table.targets.append(_target_count(fields, primitives))
        table.fields.append(fields)
        for primitive in primitives:
            mesh = _primitive(primitive, accessors, uv_uses, fields.string("name", ""), table, warnings)
            if mesh is None:
                continue
            if not geometry.has_area(mesh.positions, mesh.indices).any():
                table.empty.append(primitive.place)
                warnings.append(f"{primitive.place}: no triangle has an area; left out")
                continue
            table.parts[-1].append(len(table.meshes))
            table.meshes.append(mesh)
    return table


def _primitive(
    fields: Fields, accessors: Accessors, uv_uses: list[UvUse], name: str, table: MeshTable, warnings: list[str]
) -> Mesh | None:
    mode = fields.integer("mode", _TRIANGLES, high=6)
    if mode in _LEFT_OUT:
        warnings.append(f"{fields.place}: {_LEFT_OUT[mode]} are left out")
        return None
    attributes = fields.child("attributes")
    if attributes is None or "POSITION" not in attributes:
        raise fields.error("it has no POSITION attribute")
    accessors = decompressed(fields, accessors)
    material = fields.index("material", len(uv_uses) - 1, "material")
    positions = _attribute(attributes, accessors, "POSITION", 3)
    indices = _indices(fields, accessors, len(positions), mode, warnings)
    slot = len(uv_uses) - 1 if material is None else material
    table.take(fields, max(len(positions), 0 if "NORMAL" in attributes else indices.size))  # flat without normals
    movers = read_movers(fields, attributes, accessors, len(positions), warnings)
    return _mesh(attributes, accessors, positions, indices, movers, slot, uv_uses[slot], name)


def _target_count(fields: Fields, primitives: list[Fields]) -> int:
    counts = {len(primitive.children("targets", "target")) for primitive in primitives}
    if len(counts) > 1:
        raise fields.error(f"its primitives have {' and '.join(map(str, sorted(counts)))} morph targets, must be alike")
    return counts.pop()


def _mesh(
    attributes: Fields,
    accessors: Accessors,
    positions: np.ndarray,
    indices: np.ndarray,
    movers: Movers,
    material: int,
    uv_use: UvUse,
    name: str,
) -> Mesh:
    count = len(positions)
    key = f"TEXCOORD_{uv_use.texcoord}"
    uvs = _attribute(attributes, accessors, key, 2, count) if key in attributes else np.zeros((count, 2), np.float32)
    uvs = uv_use.apply(uvs)
    colors = _colors(attributes, accessors, count)
    tangents = None
    if "NORMAL" in attributes:
        normals = _attribute(attributes, accessors, "NORMAL", 3, count)
        normals = geometry.repair_normals(positions, normals, indices)
        if "TANGENT" in attributes and uv_use.keeps_directions():
            tangents = _stored_tangents(_attribute(attributes, accessors, "TANGENT", 4, count))
    else:  # glTF 2.0, section 3.7.2.1: flat normals, and tangents in the file are ignored
        corners = indices.ravel()
        positions, normals, uvs, indices = geometry.flat(positions, uvs, indices)
        movers = movers.take(corners).flat(positions, normals, indices)
        colors = None if colors is None else colors[corners]
    if tangents is None:
        space = tangent_space(positions, normals, uvs, indices, uv_use.normal_map)
        indices, tangents, movers = space.indices, space.tangents, movers.take(space.vertices)
        positions, normals, uvs = (array[space.vertices] for array in (positions, normals, uvs))
        colors = None if colors is None else colors[space.vertices]
    return Mesh(
        positions=positions,
        normals=normals,
        uvs=uvs,
        tangents=tangents,
        indices=indices,
        material=material,
        name=name,
        colors=colors,
        deformable=movers.deformable(positions, normals, tangents),
    )


def _colors(attributes: Fields, accessors: Accessors, count: int) -> np.ndarray | None:
    """float32 (vertices, 4), linear, of COLOR_0; None when there is none."""
    if "COLOR_0" not in attributes:
        return None
    colors = _attribute(attributes, accessors, "COLOR_0", (3, 4), count)
    opaque = np.ones((count, 4 - colors.shape[1]), np.float32)
    return np.hstack([np.clip(colors, 0.0, 1.0), opaque])  # above 1 a surface would reflect more than it gets


def _stored_tangents(stored: np.ndarray) -> np.ndarray | None:
    """The file's tangents at unit length, w = +1 or -1; None when one of them has no length and all are computed."""
    along = stored[:, :3].astype(np.float64)  # in float32 the squares of large ones would overflow
    if (np.linalg.norm(along, axis=1) < 1e-6).any():
        return None
    sign = np.where(stored[:, 3:] < 0, -1.0, 1.0)
    return np.hstack([geometry.unit(along), sign]).astype(np.float32)


def _attribute(
    attributes: Fields, accessors: Accessors, key: str, widths: int | tuple[int, ...], count: int | None = None
) -> np.ndarray:
    index = require(attributes, attributes.index(key, len(accessors), "accessor"), key)
    values = accessors.vectors(index, *((widths,) if isinstance(widths, int) else widths))
    if count is not None and len(values) != count:
        raise attributes.error(f"{key} has {len(values)} elements, POSITION has {count}")
    return values


def _indices(fields: Fields, accessors: Accessors, count: int, mode: int, warnings: list[str]) -> np.ndarray:
    """uint32 (triangles, 3), checked to lie below `count`."""
    index = fields.index("indices", len(accessors), "accessor")
    flat = np.arange(count, dtype=np.uint32) if index is None else accessors.integers(index)
    if int(flat.max()) >= count:
        raise fields.error(f"index {int(flat.max())} of only {count} vertices")
    if mode == _TRIANGLES:
        if len(flat) % 3:
            warnings.append(f"{fields.place}: {len(flat)} indices do not divide into triangles; the rest is left out")
        return flat[: len(flat) // 3 * 3].reshape(-1, 3)
    return _strip(flat) if mode == _STRIP else _fan(flat)


def _strip(flat: np.ndarray) -> np.ndarray:
    """Triangle i is (i, i + 1 + i % 2, i + 2 - i % 2): every second one is turned round (section 3.7.2.1)."""
    first = np.arange(max(len(flat) - 2, 0))
    odd = first % 2
    return np.column_stack([flat[first], flat[first + 1 + odd], flat[first + 2 - odd]])


def _fan(flat: np.ndarray) -> np.ndarray:
    """Triangle i is (i + 1, i + 2, 0)."""
    first = np.arange(max(len(flat) - 2, 0))
    return np.column_stack([flat[first + 1], flat[first + 2], np.broadcast_to(flat[:1], first.shape)])
