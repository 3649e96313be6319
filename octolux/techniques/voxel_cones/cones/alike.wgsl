// How far light of a pixel of a raw picture, of each {{ resolution }}th row and column, may be taken for another's
// (simulator/voxels/filtering.py, `alike`): by its height over the other's tangent plane, as in frame/gtao_filter.wgsl, and by
// how much its normal is turned.
{{ use("shaders/view.wgsl") }}
{{ use("shaders/gbuffer.wgsl") }}

// plane: the geometric normal over the width of a raw pixel.  ahead: the view ray along it.
struct PixelPlane { pixel: vec2i, depth: f32, plane: vec3f, ahead: f32, surface: Surface }

fn pixel_plane(pixel: vec2i) -> PixelPlane {
    let depth = textureLoad(depth_map, pixel, 0).x;
    let surface = unpack_surface(textureLoad(surface_map, pixel, 0));
    let width = {{ resolution }}.0 * length(views[0].origin_dx + depth * views[0].direction_dx);
    let plane = surface.geometric_normal / width;
    return PixelPlane(pixel, depth, plane, dot(view_ray(views[0], vec2f(pixel) + 0.5).direction, plane), surface);
}

// place: normal and depth of raw pixel `at`, of depth 0 where it has no light; so has what lies outside the picture.
fn alike(own: PixelPlane, at: vec2i, place: vec4f) -> f32 {
    let last = vec2i(textureDimensions(depth_map)) - 1;
    let moved = vec2f(min({{ resolution }} * at + {{ resolution // 2 }}, last) - own.pixel);
    let height = (place.w - own.depth) * own.ahead + dot(own.plane, between_rays(views[0], moved, place.w));
    let turn = distance(place.xyz, own.surface.normal) * {{ 1 / turned }};
    let weight = max(1.0 - abs(height), {{ least_weight }}) * max(1.0 - turn, {{ least_weight }});
    return select(0.0, weight, place.w > 0.0);
}
