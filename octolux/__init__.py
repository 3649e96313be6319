"""octolux: real-time global illumination for Python.

    import octolux
    scene = octolux.load("cornell-box")
    picture = octolux.Renderer(scene, "octree-lpv", size=(640, 480)).render()
    picture.rgb  # float32 (480, 640, 3), nits
"""

from .picture import Picture
from .renderer import Renderer
from .scene.cameras import Camera
from .scene.errors import OctoluxError, SceneError
from .scene.lights import AreaLight, DirectionalLight, ParticleLights, PointLight, SpotLight
from .scene.load import load_scene as load
from .scene.materials import Image, Material, Texture
from .scene.meshes import Instance, Mesh
from .scene.python.trimesh import from_trimesh
from .scene.scene import Environment, Scene

__version__ = "0.1.0"

__all__ = [
    "AreaLight", "Camera", "DirectionalLight", "Environment", "Image", "Instance", "Material", "Mesh", "OctoluxError",
    "ParticleLights", "Picture", "PointLight", "Renderer", "Scene", "SceneError", "SpotLight", "Texture",
    "from_trimesh", "load",
]  # fmt: skip
