"""Broken skins, morph targets and animations: one SceneError with place, problem and remedy."""

from __future__ import annotations

import numpy as np
import pytest
from figures import QUARTER_X, add_animation, add_strip

from octolux.scene.errors import SceneError
from octolux.scene.gltf.loader import load_gltf


def strip(gltf):
    """The strip with two animations, and a morph target."""
    primitive = add_strip(gltf)
    primitive["targets"] = [{"POSITION": gltf.add(np.ones((6, 3), np.float32))}]
    add_animation(gltf, 2, "rotation", [0, 1, 2], [(0, 0, 0, 1), QUARTER_X, QUARTER_X])
    add_animation(gltf, 0, "weights", [0, 1], [[0], [1]], name="grow")


def in_file(*keys):
    """Replaces a value of the JSON: the last of `keys`."""

    def change(gltf):
        target = gltf.json
        for key in keys[:-2]:
            target = target[key]
        target[keys[-2]] = keys[-1]

    return change


def accessor(*keys_and_values):
    """Puts an accessor of the given values where the JSON has another one."""
    *keys, values = keys_and_values
    return lambda gltf: in_file(*keys, gltf.add(np.asarray(values)))(gltf)


SKIN, SAMPLER, CHANNEL = ("skins", 0), ("animations", 0, "samplers", 0), ("animations", 0, "channels", 0)
ATTRIBUTES, TARGETS = ("meshes", 0, "primitives", 0, "attributes"), ("meshes", 0, "primitives", 0, "targets")
EYES = np.tile(np.eye(4, dtype=np.float32).ravel(), (2, 1))
LATE = np.float32([0, 2, 1])
NEW = "accessor 12"
SKINS = {
    "no joints": (in_file(*SKIN, "joints", []), "skin 0", "no joints"),
    "a joint that is no node": (in_file(*SKIN, "joints", [1, 9]), "skin 0: joints", "node 9"),
    "too few matrices": (accessor(*SKIN, "inverseBindMatrices", EYES[:1]), "skin 0", "2 joints and 1 inverse bind"),
    "no matrices": (accessor(*SKIN, "inverseBindMatrices", EYES[:, :4]), NEW, "type is VEC4"),
    "matrices that project": (accessor(*SKIN, "inverseBindMatrices", EYES[:, ::-1] * 2), NEW, "last row"),
    "matrices that are not finite": (accessor(*SKIN, "inverseBindMatrices", EYES * np.nan), NEW, "not finite"),
    "a joint that the skin has not": (in_file(*SKIN, "joints", [1]), "node 0", "asks for joint 1, skin 0 has 1"),
    "a skin that is not there": (in_file("nodes", 0, "skin", 3), "node 0", "skin 3"),
    "joints without weights": (lambda g: g.json["meshes"][0]["primitives"][0]["attributes"].pop("WEIGHTS_0"),
                               "mesh 0 primitive 0: attributes", "'WEIGHTS_0' is missing"),
    "weights without joints": (lambda g: g.json["meshes"][0]["primitives"][0]["attributes"].pop("JOINTS_0"),
                               "mesh 0 primitive 0: attributes", "'JOINTS_0' is missing"),
    "joints that are floats": (accessor(*ATTRIBUTES, "JOINTS_0", np.zeros((6, 4), np.float32)), NEW,
                               "8 or 16 bits"),
    "too few joints": (accessor(*ATTRIBUTES, "JOINTS_0", np.zeros((5, 4), np.uint8)), "mesh 0 primitive 0: attributes",
                       "JOINTS_0 has 5 elements, POSITION has 6"),
    "a negative weight": (accessor(*ATTRIBUTES, "WEIGHTS_0", -np.ones((6, 4), np.float32)), NEW, "negative"),
    "weights that are not finite": (accessor(*ATTRIBUTES, "WEIGHTS_0", np.full((6, 4), np.inf, np.float32)),
                                    NEW, "not finite"),
    "a pose beyond all bounds": (in_file("nodes", 2, "translation", [0, 1e30, 0]), "node 0", "beyond all bounds"),
}  # fmt: skip
MORPHS = {
    "a target of other vertices": (accessor(*TARGETS, 0, "POSITION", np.ones((2, 3), np.float32)),
                                   "mesh 0 primitive 0 target 0", "POSITION has 2"),
    "a target that is no accessor": (in_file(*TARGETS, 0, "POSITION", 99), "mesh 0 primitive 0 target 0", "99"),
    "weights for other targets": (in_file("meshes", 0, "weights", [1, 2]), "mesh 0", "must hold 1 numbers"),
    "a node's weights": (in_file("nodes", 0, "weights", []), "node 0", "must hold 1 numbers"),
}  # fmt: skip
ANIMATIONS = {
    "times that go back": (accessor(*SAMPLER, "input", LATE), "animation 0 sampler 0", "do not increase"),
    "times that are not finite": (accessor(*SAMPLER, "input", LATE * np.nan), NEW, "not finite"),
    "too few values": (accessor(*SAMPLER, "output", np.ones((2, 4), np.float32)), "animation 0 sampler 0",
                       "has 2 elements, 3 keys need 3"),
    "values of another width": (accessor(*SAMPLER, "output", np.ones((3, 3), np.float32)), NEW, "VEC3"),
    "no slopes": (in_file(*SAMPLER, "interpolation", "CUBICSPLINE"), "animation 0 sampler 0", "3 keys need 9"),
    "an unknown interpolation": (in_file(*SAMPLER, "interpolation", "QUINTIC"), "animation 0 sampler 0", "QUINTIC"),
    "a rotation of length zero": (accessor(*SAMPLER, "output", np.zeros((3, 4), np.float32)), "animation 0 sampler 0",
                                  "length zero"),
    "no output": (lambda g: g.json["animations"][0]["samplers"][0].pop("output"), "animation 0 sampler 0", "missing"),
    "a sampler that is not there": (in_file(*CHANNEL, "sampler", 4), "animation 0 channel 0", "sampler 4"),
    "no target": (lambda g: g.json["animations"][0]["channels"][0].pop("target"), "animation 0 channel 0", "missing"),
    "a target node that is not there": (in_file(*CHANNEL, "target", "node", 77), "animation 0 channel 0: target", "77"),
    "an empty animation": (in_file("animations", 0, {}), "animation 0", "no channels"),
}  # fmt: skip
OTHERS = {
    "colours for other vertices": (accessor(*ATTRIBUTES, "COLOR_0", np.ones((2, 3), np.float32)),
                                   "mesh 0 primitive 0: attributes", "COLOR_0 has 2"),
    "a hierarchy that is a ring": (in_file("nodes", 2, "children", [1]), "node 1", "cycle"),
}  # fmt: skip
BROKEN = SKINS | MORPHS | ANIMATIONS | OTHERS
FEATURES = {"glTF skins": SKINS, "glTF morph targets": MORPHS, "glTF animation": ANIMATIONS}
CASES = [
    *(
        pytest.param(name, marks=pytest.mark.covers(feature, broken=True))
        for feature, cases in FEATURES.items()
        for name in cases
    ),
    *OTHERS,
]


@pytest.mark.parametrize("name", CASES)
def test_what_is_broken_is_named(gltf, name):
    change, place, problem = BROKEN[name]
    strip(gltf)
    change(gltf)
    if name == "a pose beyond all bounds":
        gltf.json["nodes"][1]["scale"] = [1, 1e30, 1]
    path = gltf.write()
    with pytest.raises(SceneError) as caught:
        load_gltf(path)
    assert caught.value.file == str(path)
    assert caught.value.place.startswith(place)
    assert problem in caught.value.problem
    assert caught.value.remedy


@pytest.mark.covers("glTF morph targets", broken=True)
def test_unlike_numbers_of_targets(gltf):
    strip(gltf)
    primitives = gltf.json["meshes"][0]["primitives"]
    primitives.append({**primitives[0], "targets": []})
    with pytest.raises(SceneError, match="mesh 0: its primitives have 0 and 1 morph targets"):
        load_gltf(gltf.write())


def test_the_strip_itself_is_whole(gltf):
    strip(gltf)
    scene = load_gltf(gltf.write())
    assert scene.warnings == []
    assert scene.clips == ["animation 0", "grow"]
