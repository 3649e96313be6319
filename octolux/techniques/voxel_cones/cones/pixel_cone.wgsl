// A pixel's wide cones (simulator/voxels/cones.py, `gather`).
{{ use("shaders/sample_directions.wgsl") }}
{{ use("techniques/voxel_cones/cones/wide_cone.wgsl") }}
{{ use("techniques/voxel_cones/cones/pixel.wgsl") }}
{% if screen %}
{{ use("shaders/brdf.wgsl") }}
{{ use("techniques/voxel_cones/cones/screen.wgsl") }}
{% endif %}

const SETS = {{ sets }}u; // of cones, that a pixel has in a sample

// Of the sets of a pixel, of which each one of a tile has others (simulator/voxels/directions.py, `phases_of`), and each of
// {{ among }} samples a part.
fn first_phase(at: vec2u) -> u32 {
    return SETS * ({{ among }}u * (at.x % {{ tile }}u + {{ tile }}u * (at.y % {{ tile }}u)) + voxels_of.sample % {{ among }}u);
}

// albedo: of what it meets on the screen, of whose light only what it reflects of direct light is in `traced`.
struct PixelCone { towards: vec3f, traced: Traced, albedo: vec3f }

// The cone with this number, of the pixel's set that is moved by `shift`.
fn pixel_cone(seen: SeenVoxel, basis: Basis, number: u32, shift: vec2f) -> PixelCone {
    let towards = above(from_basis(basis, cone_axis(number, shift)), seen.geometric);
    {% if screen %}
    let jitter = fract({{ phases * golden }} * (f32(number) + shift.x));
    let way = screen_way(seen, towards, jitter);
    let met = way.met && seen.there;
    let traced = wide_cone(seen.start, towards, seen.geometric, select(way.free - {{ clear }}, 1e9, met), seen.there && !met);
    {% if limited %}open = select(open, select(0.0, 1.0, way.free > air.reach), met);{% endif %}
    let light = way.light{% if absorbs %} * through_air(way.free){% endif %};
    {% if noted %}
    if met { note(seen.place + way.free * towards, towards, 0.0, 1.0, vec4f(light, 1.0), Traced(vec3f(0.0), 1.0)); }
    {% endif %}
    return PixelCone(towards, Traced(select(traced.radiance, light, met), traced.left), select(vec3f(0.0), way.albedo, met));
    {% else %}
    return PixelCone(towards, wide_cone(seen.start, towards, seen.geometric, 0.0, seen.there), vec3f(0.0));
    {% endif %}
}
