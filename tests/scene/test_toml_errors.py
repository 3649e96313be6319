"""Every mistake in a TOML scene gives one SceneError that names the place and says what to write."""

from __future__ import annotations

import pytest
from toml_files import LAMP, SUN, model

from octolux.scene.errors import SceneError
from octolux.scene.toml.loader import load_toml

pytestmark = pytest.mark.covers("model .toml", broken=True)

SPOT = '[[light]]\ntype = "spot"\nposition = [0, 0, 0]\ndirection = [0, -1, 0]\nintensity = 1\n'
AREA = '[[light]]\ntype = "area"\nradiance = 1\n'
EYE = '[[camera]]\nname = "eye"\nposition = [0, 0, 5]\n'
KEYS = '[[keyframes]]\ntarget = "light:lamp"\nproperty = "position"\n'
SPIN = '[[keyframes]]\ntarget = "instance:near"\ntimes = [0]\n'
ROWS = "[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]"

# TOML text, place, what the problem and the remedy contain.
MISTAKES = {
    "not TOML": ("exposure = \n", "line 1, column 12", "not TOML", "toml.io"),
    "unknown key at the top": ("exposur = 1\n", "exposur", "no such key", "'exposure'"),
    "unknown table": ("[[ligth]]\n", "ligth", "no such key", "'light'"),
    "table for a list": ("[light]\n", "light", "list of tables", "[[light]]"),
    "list for a table": ("[[environment]]\n", "environment", "a table", "[environment]"),
    "exposure as text": ('exposure = "12"\n', "exposure", "a number, is '12'", "without quotes"),
    "exposure not finite": ("exposure = nan\n", "exposure", "not finite", "from -1e+30"),
    "infinite in a list": (LAMP.replace("[0, 0, 0]", "[0, -inf, 0]"), "[[light]] 1 'lamp': position", "not finite",
                           "1e+30"),
    "too large": (LAMP.replace("intensity = 1", "intensity = 1e300"), "[[light]] 1 'lamp': intensity", "too large",
                  "to 1e+30"),
    "far too large": ("exposure = 1" + "0" * 400 + "\n", "exposure", "too large", "to 1e+30"),
    "sky scale without image": ("[environment]\nscale = 2\n", "[environment]: scale", "without 'image'",
                                "leave it out"),
    "no sky image": ('[environment]\nimage = "sky.hdr"\n', "[environment]: image", "no file", ".hdr"),
    "a folder for a sky": ('[environment]\nimage = "."\n', "[environment]: image", "cannot be read", ".hdr"),
    "a sky that is none": ('[environment]\nimage = "model.obj"\n', "[environment]: image", "cannot be read", ".exr"),
    "a folder for a model": ('[[model]]\nfile = "."\n', "[[model]] 1: file", "is a folder", "a file in it"),
    "exposure out of range": ("exposure = 1000\n", "exposure", "is 1000", "at most 50"),
    "empty name": ('name = ""\n', "name", "must be text", "not empty"),
    "negative sky": ("[environment]\nradiance = -1\n", "[environment]: radiance", "holds -1", "at least 0"),
    "unknown sky key": ("[environment]\nradiace = 1\n", "[environment]: radiace", "no such key", "'radiance'"),
    "model without file": ("[[model]]\n", "[[model]] 1: file", "is missing", "quotes"),
    "second model": (model() + "[[model]]\n", "[[model]] 2: file", "is missing", "quotes"),
    "missing file": ('[[model]]\nfile = "modle.obj"\n', "[[model]] 1: file", "no file", "'model.obj'"),
    "misspelt built-in": ('[[model]]\nfile = "atrum"\n', "[[model]] 1: file", "no built-in", "'atrium'"),
    "unknown model key": (model("traslate = [0, 0, 0]"), "[[model]] 1: traslate", "no such key", "'translate'"),
    "unknown unit": (model('unit = "cms"'), "[[model]] 1: unit", "is 'cms'", "'cm'"),
    "unit of nothing": (model("unit = 0"), "[[model]] 1: unit", "is 0", "more than 0"),
    "unknown up": (model('up = "x"'), "[[model]] 1: up", "is 'x'", "y, z"),
    "scale 0": (model("scale = [1, 0, 1]"), "[[model]] 1: scale", "is 0", "other than 0"),
    "scale of two": (model("scale = [1, 1]"), "[[model]] 1: scale", "3 numbers", "3 numbers"),
    "translate as number": (model("translate = 3"), "[[model]] 1: translate", "3 numbers, is 3", "3 numbers"),
    "translate with text": (model('translate = [1, 2, "3"]'), "[[model]] 1: translate", "3 numbers", "3 numbers"),
    "boolean as number": (model("translate = [1, 2, true]"), "[[model]] 1: translate", "3 numbers", "3 numbers"),
    "rotate without axis": (model("rotate = { degrees = 3 }"), "[[model]] 1: rotate: axis", "is missing", "3 numbers"),
    "rotate about nothing": (model("rotate = { axis = [0, 0, 0], degrees = 3 }"), "[[model]] 1: rotate: axis",
                             "no direction", "above 0"),
    "rotate in radians": (model("rotate = { axis = [0, 1, 0], radians = 3 }"), "[[model]] 1: rotate: radians",
                          "no such key", "degrees"),
    "matrix and scale": (model(f"matrix = [{ROWS}, [0, 0, 0, 1]]\nscale = 2"), "[[model]] 1: scale", "beside 'matrix'",
                         "either"),
    "matrix of three rows": (model(f"matrix = [{ROWS}]"), "[[model]] 1: matrix", "list of lists", "4 lists of 4"),
    "matrix by columns": (model(f"matrix = [{ROWS}, [1, 2, 3, 1]]"), "[[model]] 1: matrix", "last row", "row by row"),
    "flat matrix": (model("matrix = [[1, 0, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]"), "[[model]] 1: matrix",
                    "no inverse", "independent"),
    "drop nothing": (model('drop = ["nears"]'), "[[model]] 1: drop", "'nears'", "'near'"),
    "drop as text": (model('drop = "near"'), "[[model]] 1: drop", "list of texts", '["one"'),
    "unknown normals": (model('normals = "smooth"'), "[[model]] 1: normals", "is 'smooth'", "shading, flat"),
    "textures as text": (model('textures = "no"'), "[[model]] 1: textures", "true or false", "without quotes"),
    "material without name": (model() + "[[material]]\n", "[[material]] 1: name", "is missing", "quotes"),
    "unknown material": (model() + '[[material]]\nname = "oka"\n', "[[material]] 1 'oka': name", "'oka'", "'oak'"),
    "albedo above 1": (model() + '[[material]]\nname = "oak"\nbase_color = [0.5, 1.5, 0]\n',
                       "[[material]] 1 'oak': base_color", "holds 1.5", "at most 1"),
    "roughness above 1": (model() + '[[material]]\nname = "oak"\nroughness = 2\n', "[[material]] 1 'oak': roughness",
                          "is 2", "at most 1"),
    "negative emission": (model() + '[[material]]\nname = "oak"\nemissive = -2\n', "[[material]] 1 'oak': emissive",
                          "holds -2", "at least 0"),
    "unknown material key": (model() + '[[material]]\nname = "oak"\nrougness = 1\n', "[[material]] 1 'oak': rougness",
                             "no such key", "'roughness'"),
    "unknown alpha mode": (model() + '[[material]]\nname = "oak"\nalpha_mode = "masked"\n',
                           "[[material]] 1 'oak': alpha_mode", "is 'masked'", "'mask'"),
    "light without type": ("[[light]]\n", "[[light]] 1: type", "is missing", "quotes"),
    "unknown light type": ('[[light]]\ntype = "sun"\n', "[[light]] 1: type", "is 'sun'", "directional"),
    "key of another light": (LAMP + "illuminance = 1\n", "[[light]] 1 'lamp': illuminance", "no such key", "intensity"),
    "negative intensity": (SUN + LAMP.replace("intensity = 1", "intensity = [1, -4, 1]"),
                           "[[light]] 2 'lamp': intensity", "holds -4", "at least 0"),
    "light without position": ('[[light]]\ntype = "point"\nintensity = 1\n', "[[light]] 1: position", "is missing",
                               "3 numbers"),
    "sun of no direction": (SUN.replace("[0, -2, 0]", "[0, 0, 0]"), "[[light]] 1 'sun': direction", "no direction",
                            "above 0"),
    "spot inside out": (SPOT + "inner_angle = 50\nouter_angle = 40\n", "[[light]] 1: inner_angle", "not smaller than",
                        "degrees"),
    "spot too wide": (SPOT + "outer_angle = 120\n", "[[light]] 1: outer_angle", "is 120", "at most 90"),
    "three corners": (AREA + "corners = [[0,0,0],[1,0,0],[1,1,0]]\n", "[[light]] 1: corners", "list of lists",
                      "4 lists of 3"),
    "flat corner": (AREA + "corners = [[0,0],[1,0],[1,1],[0,1]]\n", "[[light]] 1: corners", "3 numbers", "lists of 3"),
    "no area": (AREA + "corners = [[0,0,0],[1,0,0],[2,0,0],[3,0,0]]\n", "[[light]] 1: corners", "no area", "in order"),
    "bent area": (AREA + "corners = [[0,0,0],[1,0,0],[1,1,0.1],[0,1,0]]\n", "[[light]] 1: corners", "one plane",
                  "move a corner"),
    "camera at its target": (EYE + "look_at = [0, 0, 5]\n", "[[camera]] 1 'eye': look_at", "same point", "look_at"),
    "camera along up": (EYE + "look_at = [0, 0, 0]\nup = [0, 0, 1]\n", "[[camera]] 1 'eye': look_at", "up direction",
                        "turn up"),
    "field of view in half": (EYE + "look_at = [0, 0, 0]\nvertical_fov = 180\n", "[[camera]] 1 'eye': vertical_fov",
                              "is 180", "less than 180"),
    "near of nothing": (EYE + "look_at = [0, 0, 0]\nnear = 0\n", "[[camera]] 1 'eye': near", "is 0", "more than 0"),
    "unknown camera key": (EYE + "look_at = [0, 0, 0]\nfov = 50\n", "[[camera]] 1 'eye': fov", "no such key",
                           "vertical_fov"),
    "target without kind": (LAMP + KEYS.replace("light:", ""), "[[keyframes]] 1: target", "is 'lamp'", "light:NAME"),
    "unknown target": (LAMP + KEYS.replace("lamp", "lmap"), "[[keyframes]] 1: target", "no light 'lmap'", "'lamp'"),
    "target of nothing": (KEYS, "[[keyframes]] 1: target", "no light 'lamp'", "nothing it could name"),
    "property of another light": (SUN + KEYS.replace("lamp", "sun"), "[[keyframes]] 1: property", "is 'position'",
                                  "direction, illuminance"),
    "times out of order": (LAMP + KEYS + "times = [1, 0]\nvalues = [[0,0,0],[1,1,1]]\n", "[[keyframes]] 1: times",
                           "do not increase", "in order"),
    "no times": (LAMP + KEYS + "times = []\nvalues = []\n", "[[keyframes]] 1: times", "is empty", "at least one"),
    "values for other times": (LAMP + KEYS + "times = [0, 1, 2]\nvalues = [[0,0,0],[1,1,1]]\n",
                               "[[keyframes]] 1: values", "2 entries for 3 times", "each time"),
    "values too long": (LAMP + KEYS + "times = [0]\nvalues = [[0,0,0,0]]\n", "[[keyframes]] 1: values", "3 numbers",
                        "lists of 3"),
    "negative key": (LAMP + KEYS.replace("position", "intensity") + "times = [0]\nvalues = [[0,-1,0]]\n",
                     "[[keyframes]] 1: values", "negative intensity, -1", "0 or more"),
    "rotation of nothing": (model() + SPIN + 'property = "rotation"\nvalues = [[0,0,0,0]]\n', "[[keyframes]] 1: values",
                            "length 0", "above 0"),
    "scale key of 0": (model() + SPIN + 'property = "scale"\nvalues = [[1,0,1]]\n', "[[keyframes]] 1: values",
                       "not positive", "above 0"),
    "unknown keyframe key": (LAMP + KEYS + "time = [0]\n", "[[keyframes]] 1: time", "no such key", "'times'"),
}  # fmt: skip


@pytest.mark.parametrize("name", MISTAKES)
def test_mistakes_are_named_with_place_and_remedy(toml, tmp_path, name):
    text, place, problem, remedy = MISTAKES[name]
    with pytest.raises(SceneError) as caught:
        toml(text)
    error = caught.value
    assert error.file == str(tmp_path / "scene.toml")
    assert error.place == place
    message = str(error).removeprefix(f"{error.file}: {error.place}: ")
    assert problem in message
    assert remedy in message


def test_the_data_folder_that_is_not_there(toml, tmp_path, monkeypatch):
    monkeypatch.setenv("OCTOLUX_DATA", str(tmp_path / "nowhere"))
    with pytest.raises(SceneError, match=r"\[\[model\]\] 1: file: .*nowhere.*OCTOLUX_DATA"):
        toml('[[model]]\nfile = "data:x.obj"\n')


def test_a_data_file_that_is_not_there_suggests_one_with_its_prefix(toml, tmp_path, monkeypatch):
    (tmp_path / "scenes").mkdir()
    (tmp_path / "scenes" / "hall.obj").write_text("v 0 0 0\n")
    monkeypatch.setenv("OCTOLUX_DATA", str(tmp_path))
    with pytest.raises(SceneError, match=r"'data:hall\.obj' is meant"):
        toml('[[model]]\nfile = "data:halle.obj"\n')


def test_mistakes_inside_a_model_name_the_models_file(toml, tmp_path):
    (tmp_path / "empty.obj").write_text("")
    with pytest.raises(SceneError) as caught:
        toml('[[model]]\nfile = "empty.obj"\n')
    assert caught.value.file.endswith("empty.obj")


def test_a_scene_that_includes_itself(toml, tmp_path):
    (tmp_path / "other.toml").write_text('[[model]]\nfile = "scene.toml"\n')
    with pytest.raises(SceneError, match=r"includes itself: scene\.toml -> other\.toml -> scene\.toml"):
        toml('[[model]]\nfile = "other.toml"\n')
    (tmp_path / "other.toml").write_text('[[model]]\nfile = "furnace"\n')
    assert toml('[[model]]\nfile = "other.toml"\n').triangle_count == 12  # the failure left nothing behind


@pytest.mark.parametrize(("content", "problem"), [
    (b"name = '\xff'", "not UTF-8"),
    (b"a = " + b"[" * 3000, "nested too deeply"),
])  # fmt: skip
def test_files_that_are_no_text(tmp_path, content, problem):
    path = tmp_path / "s.toml"
    path.write_bytes(content)
    with pytest.raises(SceneError, match=problem):
        load_toml(path)


def test_a_file_that_cannot_be_read(tmp_path):
    with pytest.raises(SceneError, match="cannot be read"):
        load_toml(tmp_path / "nothing.toml")
