"""Struct layouts: what Python packs is what WGSL reads."""

from __future__ import annotations

import numpy as np
import pytest
from gpu_tools import one_stage, read_buffer

from octolux.frame import structs as frame_structs
from octolux.gpu.bindings import storage, storage_rw, uniform
from octolux.gpu.layout import _TYPES, Struct
from octolux.gpu.passes import ComputePass
from octolux.gpu_scene import structs as scene_structs
from octolux.techniques.lpv.constants import GRID
from octolux.techniques.lpv.injection import SOURCE

# Every type, in an order that leaves gaps of every kind before and after it.
EVERYTHING = Struct(
    "Everything", a="f32", b="vec2f", c="u32", d="vec3f", e="i32", f="vec3u", g="vec4f", h="f32", i="mat4x4f",
    j="vec2u", k="u32", l="vec3i", m="vec3f", n="vec4u", o="u32",
)  # fmt: skip


def all_structs() -> list[Struct]:
    found = [EVERYTHING, GRID, SOURCE]
    for module in (frame_structs, scene_structs):
        found += [value for value in vars(module).values() if isinstance(value, Struct)]
    return found


def components(struct: Struct) -> list[str]:
    """WGSL expressions of every scalar of `given`, as bits."""
    out = []
    for name, kind in struct.fields:
        base, shape = _TYPES[kind][:2]
        indices = ["".join(f"[{i}]" for i in index) for index in np.ndindex(shape)]
        out += [f"bitcast<u32>(given.{name}{index})" if base != "u4" else f"given.{name}{index}" for index in indices]
    return out


def random_values(struct: Struct, rng) -> np.ndarray:
    packed = struct.array(1)
    for name, kind in struct.fields:
        base, shape = _TYPES[kind][:2]
        low = 0 if base == "u4" else -1000
        packed[name][0] = rng.normal(size=shape) if base == "f4" else rng.integers(low, 1000, shape)
    return packed


def read_on_device(device, tmp_path, struct: Struct, packed: np.ndarray, as_uniform: bool) -> np.ndarray:
    """All scalars of `packed` as a shader sees them, as bits."""
    expressions = components(struct)
    lines = "\n".join(f"    result[{i}] = {e};" for i, e in enumerate(expressions))
    given = "" if as_uniform else "    let given = items[0];\n"
    source = tmp_path / "fields.wgsl"
    source.write_text(f"@compute @workgroup_size({{{{ workgroup }}}})\nfn main() {{\n{given}{lines}\n}}\n")
    name = "given" if as_uniform else "items"
    binding = (uniform if as_uniform else storage)(name, struct)
    reader = ComputePass(device, "fields", str(source), [binding, storage_rw("result", "u32")], structs=[struct],
                         workgroup=(1, 1, 1))  # fmt: skip
    buffer = device.uniform("packed", packed) if as_uniform else device.buffer("packed", packed)
    result = device.buffer("result", size=4 * len(expressions))
    with one_stage(device) as stage:
        reader.run(stage, (1,), **{name: buffer, "result": result})
    return read_buffer(device, result, np.uint32)[: len(expressions)]


@pytest.mark.parametrize("struct", all_structs(), ids=lambda s: s.name)
def test_fields_arrive(device, tmp_path, struct):
    packed = random_values(struct, np.random.default_rng(0))
    expected = np.concatenate([packed[name][0].ravel().view(np.uint32) for name, _ in struct.fields])
    assert np.array_equal(read_on_device(device, tmp_path, struct, packed, as_uniform=False), expected)


def test_uniform_buffers_have_the_same_layout(device, tmp_path):
    packed = random_values(EVERYTHING, np.random.default_rng(1))
    both = [read_on_device(device, tmp_path, EVERYTHING, packed, as_uniform) for as_uniform in (True, False)]
    assert np.array_equal(*both) and both[0].any()


def test_elements_of_an_array(device, tmp_path):
    """The stride of array elements: the last field of the third element arrives."""
    packed = EVERYTHING.array(3)
    packed["o"] = [1, 2, 3]
    source = tmp_path / "stride.wgsl"
    source.write_text("@compute @workgroup_size({{ workgroup }})\nfn main() { result[0] = items[2].o; }\n")
    bindings = [storage("items", EVERYTHING), storage_rw("result", "u32")]
    reader = ComputePass(device, "stride", str(source), bindings, structs=[EVERYTHING], workgroup=(1, 1, 1))
    result = device.buffer("result", size=4)
    with one_stage(device) as stage:
        reader.run(stage, (1,), items=device.buffer("items", packed), result=result)
    assert read_buffer(device, result, np.uint32)[0] == 3


def test_matrices_are_given_transposed():
    matrix = np.arange(16.0).reshape(4, 4)
    packed = Struct("M", m="mat4x4f").pack(m=matrix.T)
    assert np.array_equal(packed["m"].ravel(), matrix.T.ravel())


def test_bad_structs():
    with pytest.raises(ValueError, match=r"struct Bad: x: vec5f; types are .*vec3f"):
        Struct("Bad", x="vec5f")
    with pytest.raises(ValueError, match="no fields"):
        Struct("Empty")
    with pytest.raises(TypeError, match=r"\['origin', 'cell_size', 'n'\]"):
        GRID.pack(origin=(0, 0, 0), cell_size=1.0)
