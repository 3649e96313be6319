"""Bind groups and passes: what they ask for, what they keep, and what they say they read and write."""

from __future__ import annotations

import numpy as np
import pytest
from gpu_tools import one_stage, read_buffer

from octolux.gpu.bindings import BindGroup, sampler, storage, storage_rw, storage_texture, texture, uniform
from octolux.gpu.layout import Struct
from octolux.gpu.passes import ComputePass

ADD = """@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&b) { return; }
    b[id.x] += a[id.x];
}
"""


@pytest.fixture
def add(device, tmp_path):
    """A pass that adds `a` to `b`."""
    (tmp_path / "add.wgsl").write_text(ADD)
    bindings = [storage("a", "f32"), storage_rw("b", "f32")]
    return ComputePass(device, "add", str(tmp_path / "add.wgsl"), bindings, workgroup=(64, 1, 1))


def numbers(device, values):
    return device.buffer("numbers", np.asarray(values, np.float32))


def test_missing_and_unknown_resources(device, add):
    a, b = numbers(device, [1.0]), numbers(device, [2.0])
    with one_stage(device) as stage:
        with pytest.raises(TypeError, match=r"bindings are \['a', 'b'\], got \['a'\]"):
            add.own.group(device, {"a": a})
        with pytest.raises(TypeError, match=r"got \['a', 'b', 'c'\]"):
            add.own.group(device, {"a": a, "b": b, "c": a})
        add.run(stage, (1,), a=a, b=b)


def test_a_name_twice():
    with pytest.raises(ValueError, match="declared twice"):
        BindGroup([storage("a", "f32"), uniform("a", "f32")])


def test_groups_are_kept_by_their_resources(device, add):
    a, b, c = (numbers(device, [i]) for i in range(3))
    first = add.own.group(device, {"a": a, "b": b})
    assert add.own.group(device, {"b": b, "a": a}) is first
    assert add.own.group(device, {"a": c, "b": b}) is not first


def test_a_new_resource_at_an_old_address_is_new(device, add):
    """CPython gives a freed object's id to the next of its size: the cache must not mix them up."""
    total, ids = numbers(device, [0.0]), []
    for value in range(40):  # more than are kept
        fresh = numbers(device, [value])
        ids.append(id(fresh))
        with one_stage(device) as stage:
            add.run(stage, (1,), a=fresh, b=total)
        del fresh
    assert read_buffer(device, total)[0] == sum(range(40))
    assert len(set(ids)) < len(ids), "no address came back: the test shows nothing"


def test_each_dispatch_sees_what_the_former_wrote(device, add):
    a, b, c = numbers(device, [1.0, 2.0]), numbers(device, [10.0, 20.0]), numbers(device, [0.0, 0.0])
    with one_stage(device) as stage:
        add.run_many(stage, (2,), [{"a": a, "b": b}, {"a": b, "b": c}, {"a": c, "b": a}])
    assert read_buffer(device, a)[:2].tolist() == [12.0, 24.0]


@pytest.mark.parametrize("threads", [1, 63, 64, 65, 1000])
def test_as_many_threads_as_asked(device, add, threads):
    a, b = numbers(device, np.ones(threads)), numbers(device, np.zeros(threads))
    with one_stage(device) as stage:
        add.run(stage, (threads,), a=a, b=b)
    assert read_buffer(device, b)[:threads].tolist() == [1.0] * threads


def test_reads_and_writes(device, tmp_path):
    (tmp_path / "empty.wgsl").write_text("@compute @workgroup_size({{ workgroup }})\nfn main() {}\n")
    shared = BindGroup([texture("picture", "float"), sampler("filtered")])
    bindings = [
        storage("given", "f32"), storage_rw("both", "f32"), storage_rw("result", "f32", "write"),
        storage_texture("painted", "rgba8unorm"), uniform("number", Struct("Number", x="f32")),
    ]  # fmt: skip
    made = ComputePass(device, "empty", str(tmp_path / "empty.wgsl"), bindings, shared=shared,
                       structs=[Struct("Number", x="f32")])  # fmt: skip
    assert made.reads == ["given", "both", "number", "picture", "filtered"]
    assert made.writes == ["both", "result", "painted"]
