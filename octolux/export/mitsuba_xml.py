"""A description of a Mitsuba scene (nested dictionaries, as `mitsuba.load_dict` takes them) as XML."""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree

import numpy as np

TAGS = {
    **dict.fromkeys(("path", "volpath"), "integrator"),
    **dict.fromkeys(("perspective", "orthographic"), "sensor"),
    "hdrfilm": "film", "box": "rfilter", "independent": "sampler", "ply": "shape",
    **dict.fromkeys(("diffuse", "principled", "octolux_gltf", "normalmap", "mask", "twosided", "null"), "bsdf"),
    **dict.fromkeys(("directional", "point", "spot", "area", "constant", "envmap"), "emitter"),
    **dict.fromkeys(("bitmap", "mesh_attribute"), "texture"),
}  # fmt: skip
"""The element of each plugin that the exporter uses."""

VERSION = "3.0.0"


def scene_xml(description: dict[str, Any]) -> str:
    """The text of the file. Values: bool, int, float, str, three floats (a point or a vector), (4, 4) arrays
    (transforms), {"type": "rgb", ...}, {"type": "ref", "id": ...} and plugins."""
    root = ElementTree.Element("scene", version=VERSION)
    for name, value in description.items():
        if name != "type":
            root.append(_plugin(value, identity=name))
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode") + "\n"


def _plugin(value: dict[str, Any], name: str = "", identity: str = "") -> ElementTree.Element:
    element = ElementTree.Element(TAGS[value["type"]], type=value["type"])
    if identity:
        element.set("id", identity)
    if name:
        element.set("name", name)
    for key, inner in value.items():
        if key != "type":
            element.append(_property(key, inner))
    return element


def _property(name: str, value: Any) -> ElementTree.Element:
    if isinstance(value, dict):
        if value["type"] == "rgb":
            return ElementTree.Element("rgb", name=name, value=_numbers(value["value"]))
        if value["type"] == "ref":
            return ElementTree.Element("ref", name=name, id=value["id"])
        return _plugin(value, name)
    if isinstance(value, np.ndarray):
        transform = ElementTree.Element("transform", name=name)
        ElementTree.SubElement(transform, "matrix", value=_numbers(value.ravel()))
        return transform
    if isinstance(value, tuple):
        tag = "point" if name == "position" else "vector"
        return ElementTree.Element(tag, {"name": name, **dict(zip("xyz", map(repr, value), strict=True))})
    tag = {bool: "boolean", int: "integer", float: "float", str: "string"}[type(value)]
    return ElementTree.Element(tag, name=name, value=str(value).lower() if isinstance(value, bool) else str(value))


def _numbers(values: Any) -> str:
    return " ".join(repr(float(v)) for v in values)
