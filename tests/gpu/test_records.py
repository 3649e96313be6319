"""Structs in storage textures (gpu/records.py): what is stored is loaded again, bit by bit."""

from __future__ import annotations

import numpy as np
import pytest
from gpu_tools import one_stage

from octolux.gpu.layout import Struct
from octolux.gpu.passes import ComputePass
from octolux.gpu.records import (
    read_records,
    read_words,
    record_texture,
    records,
    records_out,
    word_texture,
    words,
    words_out,
)

RECORD = Struct("Record", place="vec3f", number="u32", pair="vec2u", offset="i32", weight="f32", colour="vec4f")
# Members of a record are told apart: each comes back changed in its own way.
KERNEL = """
@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= {{ count }}u { return; }
    let r = load_given(id.x);
    let changed = Record(-r.place, r.number + 1u, r.pair.yx, -r.offset, 2.0 * r.weight, r.colour);
    store_made({{ count - 1 }}u - id.x, changed);
}
"""


@pytest.mark.parametrize("count", [1, 3000])  # a row holds 1365 and a third
def test_round_trip(device, tmp_path, count):
    rng = np.random.default_rng(1)
    data = RECORD.array(count)
    for name in ("place", "weight", "colour"):
        data[name] = rng.normal(size=data[name].shape)
    for name in ("number", "pair", "offset"):
        data[name] = rng.integers(0, 2**31 - 1, size=data[name].shape)
    (tmp_path / "k.wgsl").write_text(KERNEL)
    kernel = ComputePass(
        device, "records", str(tmp_path / "k.wgsl"), [records("given", RECORD), records_out("made", RECORD)],
        structs=[RECORD], workgroup=(64, 1, 1), count=count,
    )  # fmt: skip
    made = record_texture(device, "made", RECORD, count)
    with one_stage(device) as stage:
        kernel.run(stage, (count,), given=record_texture(device, "given", RECORD, count, data), made=made)
    found = read_records(device, made, RECORD, count)[::-1]
    changes = {"place": -data["place"], "number": data["number"] + 1, "pair": data["pair"][:, ::-1],
               "offset": -data["offset"], "weight": 2.0 * data["weight"], "colour": data["colour"]}  # fmt: skip
    for name, expected in changes.items():
        np.testing.assert_array_equal(found[name], expected, err_msg=name)


WORDS = """
@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x < {{ count }}u { store_made({{ count - 1 }}u - id.x, load_given(id.x) ^ 0xffffu); }
}
"""


@pytest.mark.parametrize("count", [1, 4096, 9000])  # a row holds 4096
def test_words_round_trip(device, tmp_path, count):
    data = np.random.default_rng(2).integers(0, 2**32, count, dtype=np.uint32)
    (tmp_path / "k.wgsl").write_text(WORDS)
    kernel = ComputePass(device, "words", str(tmp_path / "k.wgsl"), [words("given"), words_out("made")],
                         workgroup=(64, 1, 1), count=count)  # fmt: skip
    given, made = word_texture(device, "given", count, data), word_texture(device, "made", count)
    with one_stage(device) as stage:
        kernel.run(stage, (count,), given=given, made=made)
    np.testing.assert_array_equal(read_words(device, made, count)[::-1], data ^ 0xFFFF)


def test_a_struct_that_does_not_fill_words_is_refused():
    with pytest.raises(ValueError, match="not a multiple of 16"):
        records("given", Struct("Odd", number="u32"))
