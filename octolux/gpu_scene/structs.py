"""The scene's structs, declared once for NumPy and WGSL."""

from ..gpu.layout import Struct

# Unit vectors are octahedral, 2 x 16 bits (shaders/octahedral.wgsl); the tangent's lowest bit is its sign.
# Vertex colours are 4 x 8 bits, the square roots of the linear values (gpu_scene/packing.py).
VERTEX = Struct("Vertex", position="vec3f", normal="u32", uv="vec2f", tangent="u32", color="u32")
# Rows of the object-to-world matrix; `flipped` is 1 where it mirrors, so that the winding turns round. size: longest
# edge of its box in the world, m. moving: 1 where it is not static (gpu_scene/history.py).
INSTANCE = Struct(
    "Instance", row0="vec4f", row1="vec4f", row2="vec4f", material="u32", flipped="u32", size="f32", moving="u32",
)  # fmt: skip
# Corners of a triangle: numbers of vertices.
TRIANGLE = Struct("Triangle", a="u32", b="u32", c="u32", padding="u32")
# A cluster of one instance: the unit that is culled and drawn.
ITEM = Struct("Item", instance="u32", first_triangle="u32", triangle_count="u32", padding="u32")
# Texture fields are references as gpu_scene/textures.py packs them; their _u and _v are the rows of the transform of
# texture coordinates, with log2 of its stretch behind the first. alpha_mode: 0 opaque, 1 mask, 2 blend.
MATERIAL = Struct(
    "Material", base_color="vec3f", alpha="f32", emissive="vec3f", alpha_cutoff="f32", metallic="f32", roughness="f32",
    specular="f32", normal_scale="f32", base_color_texture="u32", metallic_roughness_texture="u32",
    normal_texture="u32", emissive_texture="u32", alpha_mode="u32", unlit="u32", double_sided="u32",
    base_color_texture_u="vec4f", base_color_texture_v="vec4f",
    metallic_roughness_texture_u="vec4f", metallic_roughness_texture_v="vec4f",
    normal_texture_u="vec4f", normal_texture_v="vec4f", emissive_texture_u="vec4f", emissive_texture_v="vec4f",
)  # fmt: skip
