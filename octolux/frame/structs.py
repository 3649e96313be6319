"""The frame's structs, declared once for NumPy and WGSL."""

from ..gpu.bindings import Binding, uniform
from ..gpu.layout import Struct
from ..gpu.limits import DEFAULT_LIMITS

# A camera or a light's face. The ray of pixel (x, y) starts at origin + x origin_dx + y origin_dy and runs along
# direction + x direction_dx + y direction_dy, whose part along the view's axis has length 1. size: pixels across.
# depth_scale: the depth map holds depth_scale / depth (near) in a perspective, and falls by depth_scale per metre else.
VIEW = Struct(
    "View", view_projection="mat4x4f", origin="vec3f", size="f32", origin_dx="vec3f", perspective="u32",
    origin_dy="vec3f", light="u32", direction="vec3f", depth_scale="f32", direction_dx="vec3f", direction_dy="vec3f",
)  # fmt: skip
# All that the rasteriser needs of a view; 256 bytes apart, so that one buffer serves all views at dynamic offsets.
# sample, samples: which of the samples of each pixel is drawn, and of how many.
RASTER_VIEW = Struct("RasterView", view_projection="mat4x4f", sample="u32", samples="u32")
RASTER_VIEW_STRIDE = DEFAULT_LIMITS["min-uniform-buffer-offset-alignment"]
# color: candela, or lux for directional lights. texel: width of a shadow texel in metres, per metre of depth where the
# view is a perspective. cos_outer and cone_slope are a spot's; a slope of 0 is no cone. An emitter
# has its axis, beam and squared radius in direction, cos_outer and cone_slope.
LIGHT = Struct(
    "Light", position="vec3f", texel="f32", direction="vec3f", cos_outer="f32", color="vec3f", cone_slope="f32",
)  # fmt: skip
# An area light, for shaders/ltc.wgsl: a corner and three edges, clockwise seen from where it shines to; nits. It is
# shadowed by so many `emitters`, from number `first` of them on.
AREA_LIGHT = Struct(
    "AreaLight", corner="vec3f", first="u32", edge0="vec3f", emitters="u32", edge1="vec3f", edge2="vec3f",
    radiance="vec3f",
)  # fmt: skip
# A texel of an RSM as a light: position and normal (octahedral) in world space; flux it reflects (lm or W); area of
# its surface (m^2, simulator/rsm.py's vpl_area), 0 where the light meets nothing.
VPL = Struct("Vpl", position="vec3f", normal="u32", flux="vec3f", area="f32")
# The surroundings: a constant (nits) and a map of `levels` mip levels, turned by `turn` (u). texels: as many as would
# cover the sphere at the size of those at the horizon.
ENVIRONMENT = Struct("EnvironmentSettings", radiance="vec3f", turn="f32", levels="f32", texels="f32")
# exposure: from nits to the picture's unit. weight: of this sample in the mean of the pixel's samples.
# Where a set of shadow maps begins among the views, its VPLs in their buffer; whether its lights may be emitters.
RSM_SET = Struct("RsmSet", first_view="u32", first_vpl="u32", emitters="u32")
# Of the sky's lights a sample asks every `step`-th.
SKY_PICK = Struct("SkyPick", sample="u32", step="u32")
COMPOSITE = Struct("CompositeSettings", exposure="f32", weight="f32")

# Views and lights are uniform arrays of fixed length: a software adapter reads those several times faster than storage.
MAX_LIGHTS = DEFAULT_LIMITS["max-texture-array-layers"]  # each has at least one layer of the shadow maps
MAX_VIEWS = MAX_LIGHTS + 1


def views_binding() -> Binding:
    return uniform("views", f"array<View, {MAX_VIEWS}>")


def lights_binding() -> Binding:
    return uniform("lights", f"array<Light, {MAX_LIGHTS}>")
