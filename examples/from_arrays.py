"""A scene from NumPy arrays: hills, coloured by their height, under a sun."""

from math import radians

import numpy as np

import octolux

# A grid of 100 x 100 points, 10 m wide, and two triangles between each four of them.
z, x = np.meshgrid(np.linspace(-5, 5, 100), np.linspace(-5, 5, 100))
height = np.sin(x) * np.cos(z)
positions = np.stack([x, height, z], axis=-1).reshape(-1, 3)
corner = np.arange(99 * 100).reshape(99, 100)[:, :99].ravel()
indices = np.stack([corner, corner + 1, corner + 100, corner + 100, corner + 1, corner + 101], axis=-1).reshape(-1, 3)
share = (positions[:, 1:] * 0.5 + 0.5)[:, :1]
colors = share * (0.8, 0.8, 0.7) + (1 - share) * (0.1, 0.3, 0.1)  # linear; green valleys, pale tops

scene = octolux.Scene.from_arrays(positions, indices, colors=colors, name="hills")
scene.lights.append(octolux.DirectionalLight(direction=(1, -1, -0.5), illuminance=(60000, 57000, 50000)))  # lux
scene.cameras.append(octolux.Camera.look_at((0, 4, 8), (0, 0, 0), vertical_fov=radians(50)))
scene.environment = octolux.Environment(radiance=(2000, 3000, 5000))  # nits

picture = octolux.Renderer(scene, "octree-lpv", size=(320, 240)).render()
picture.save("hills.png")
print(scene.triangle_count, "triangles, mean radiance", picture.rgb.mean(), "nits")
