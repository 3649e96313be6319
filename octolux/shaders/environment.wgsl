// The surroundings: what is seen and reflected of them, and their irradiance (references: simulator/environment.py).
// The maps are rgba32float, since the sun's nits are beyond 16 bits: filtered here, not by a sampler.
{{ use("shaders/even_reflection.wgsl") }}

fn environment_uv(d: vec3f) -> vec2f {
    let u = 0.5 + atan2(d.x, -d.z) / {{ 2 * pi }} + environment.turn;
    return vec2f(u, acos(clamp(d.y, -1.0, 1.0)) / {{ pi }});
}

{% macro bilinear(name, map) %}
fn {{ name }}(uv: vec2f, level: i32) -> vec3f {
    let size = vec2i(textureDimensions({{ map }}, level));
    let at = uv * vec2f(size) - 0.5;
    let low = floor(at);
    let part = at - low;
    let left = (vec2i(low).x % size.x + size.x) % size.x;
    let right = (left + 1) % size.x;
    let top = clamp(vec2i(low).y, 0, size.y - 1);
    let below = clamp(vec2i(low).y + 1, 0, size.y - 1);
    let upper = mix(textureLoad({{ map }}, vec2i(left, top), level), textureLoad({{ map }}, vec2i(right, top), level), part.x);
    let lower = mix(textureLoad({{ map }}, vec2i(left, below), level), textureLoad({{ map }}, vec2i(right, below), level), part.x);
    return mix(upper, lower, part.y).rgb;
}
{% endmacro %}
{{ bilinear("map_texel", "environment_map") }}

// Nits from unit direction `d`.
fn environment_radiance(d: vec3f) -> vec3f {
    return environment.radiance + map_texel(environment_uv(d), 0);
}

{% if sky %}
{{ bilinear("irradiance_texel", "environment_irradiance") }}

// Lux on a surface that faces unit direction `n`, without shadows.
fn environment_irradiance_at(n: vec3f) -> vec3f { return irradiance_texel(environment_uv(n), 0); }

// Mean nits over a GGX lobe around unit direction `d`: from the mip level whose texels are as large as the lobe. A lobe of
// half vectors has the solid angle pi alpha^2, that of directions four times as much (dl = 4 v.h dh).
fn environment_lobe(d: vec3f, alpha: f32) -> vec3f {
    let level = clamp(0.5 * log2(max(alpha * alpha * environment.texels, 1.0)), 0.0, environment.levels - 1.0);
    let uv = environment_uv(d);
    let fine = i32(floor(level));
    let coarse = min(fine + 1, i32(environment.levels) - 1);
    return environment.radiance + mix(map_texel(uv, fine), map_texel(uv, coarse), fract(level));
}
{% endif %}
