"""Load a scene, change a light, render to NumPy arrays."""

from dataclasses import replace

import octolux

scene = octolux.load("cornell-box")
scene.lights[0] = replace(scene.lights[0], intensity=(80.0, 50.0, 25.0))  # candela: a warmer lamp

renderer = octolux.Renderer(scene, technique="octree-lpv", size=(640, 480))
picture = renderer.render()

print(picture.rgb.shape, picture.rgb.dtype, "mean", picture.rgb.mean(), "nits")
print("indirect light:", picture.layers["indirect"].mean(), "nits of it")
picture.save("change_a_light.png")
