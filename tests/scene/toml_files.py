"""A small OBJ model, TOML scenes written beside it, and tables that several of them hold."""

from __future__ import annotations

from pathlib import Path

from octolux.scene.scene import Scene
from octolux.scene.toml.loader import load_toml

OBJ = """mtllib model.mtl
v 0 0 0
v 1 0 0
v 1 2 0
v 0 2 3
vt 0 0
vt 1 0
vt 1 1
vn 0 0 1
g near
usemtl oak
f 1/1/1 2/2/1 3/3/1
g far
usemtl pine
f -4/-3/-1 -2/-2/-1 -1/-1/-1
"""
MTL = "newmtl oak\nKd 0.5 0.4 0.3\nmap_Kd wood.png\nnewmtl pine\nKd 0.2 0.2 0.2\nmap_Kd wood.png\n"
SUN = '''[[light]]
type = "directional"
name = "sun"
direction = [0, -2, 0]
illuminance = [3, 2, 1]
'''
LAMP = '''[[light]]
type = "point"
name = "lamp"
position = [0, 0, 0]
intensity = 1
'''
SPOT = '''[[light]]
type = "spot"
name = "spot"
position = [0, 3, 0]
direction = [0, -1, 0]
intensity = 100
inner_angle = 20
outer_angle = 30
'''


def write_model(folder: Path) -> None:
    """model.obj: a triangle "near" of "oak" and a triangle "far" of "pine"; both have the picture wood.png."""
    (folder / "model.obj").write_text(OBJ)
    (folder / "model.mtl").write_text(MTL)


def load_text(folder: Path, text: str) -> Scene:
    """The scene of a TOML file scene.toml in `folder`."""
    path = folder / "scene.toml"
    path.write_text(text)
    return load_toml(path)


def model(more: str = "") -> str:
    """A [[model]] table that loads model.obj, with more keys."""
    return f'[[model]]\nfile = "model.obj"\n{more}\n'
