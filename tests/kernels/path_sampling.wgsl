// Test kernel: what the path tracer draws at a surface, one `mode` each. Nothing is in the way of a ray.
{{ use("shaders/brdf.wgsl") }}
{{ use("shaders/environment.wgsl") }}
{{ use("shaders/sampler.wgsl") }}
{{ use("shaders/sample_directions.wgsl") }}
{{ use("techniques/path_tracer/surface_sampling.wgsl") }}

const FAR = 3.0e38;
struct Vertex_ { position: vec3f, to_eye: vec3f, surface: Surface }
fn offset_origin(position: vec3f, geometric_normal: vec3f, direction: vec3f) -> vec3f { return position; }
fn any_hit(origin: vec3f, direction: vec3f, t_min: f32, t_max: f32, seed: u32) -> bool { return false; }
{{ use("techniques/path_tracer/lights.wgsl") }}

fn triple(first: u32) -> vec3f { return vec3f(given[first], given[first + 1u], given[first + 2u]); }

// normal, eye, base colour, roughness, metallic, specular.
fn surface_at(i: u32) -> Surface {
    return Surface(triple(i), triple(i), triple(i + 6u), given[i + 9u], given[i + 10u], given[i + 11u]);
}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let thread = id.x + id.y * {{ row }}u;
    if thread >= {{ threads }}u { return; }
    let i = thread * {{ inputs }}u;
    {% if mode == "bounce" %}
    let bounce = sample_bounce(surface_at(i), triple(i + 3u), given[i + 12u], vec2f(given[i + 13u], given[i + 14u]));
    let found = array<f32, 7>(bounce.direction.x, bounce.direction.y, bounce.direction.z, bounce.density,
        bounce.weight.x, bounce.weight.y, bounce.weight.z);
    {% elif mode == "density" %}
    let found = array<f32, 1>(bounce_density_of(surface_at(i), triple(i + 3u), triple(i + 12u)));
    {% elif mode == "reflection" %}
    let found = reflection(surface_at(i), triple(i + 3u), triple(i + 12u));
    {% elif mode == "sky" %}
    let sky = sample_sky(vec2f(given[i], given[i + 1u]), vec2f(given[i + 2u], given[i + 3u]));
    let found = vec4f(sky.direction, sky.density);
    {% elif mode == "sky density" %}
    let found = array<f32, 1>(sky_cell_density(triple(i)));
    {% else %}
    let emitter = emitter_of(given[i]);
    let found = array<f32, 2>(f32(emitter.id), area_density(emitter.radiance));
    {% endif %}
    for (var k = 0u; k < {{ outputs }}u; k++) { result[{{ outputs }}u * thread + k] = found[k]; }
}
