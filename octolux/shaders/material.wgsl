// Material textures: a reference says layer, size class and wrap modes (gpu_scene/textures.py). The mip level is explicit,
// so this runs in compute shaders and in any control flow; it is worked out once for all textures of a surface.

const NO_TEXTURE = 0u;

// `rim` is half a texel: the repeating sampler must not reach across the image's edge in the other modes.
fn wrapped(x: f32, mode: u32, rim: f32) -> f32 {
    let mirrored = 1.0 - abs(1.0 - (x - 2.0 * floor(0.5 * x)));
    return select(x, clamp(select(x, mirrored, mode == 1u), rim, 1.0 - rim), mode != 0u);
}

// Logarithm to base 2 of a pixel's footprint in texture coordinates: the longer of its changes to the right and down.
// Adding log2 of an image's edge gives its mip level, as hardware does without anisotropy.
fn log2_footprint(dx: vec2f, dy: vec2f) -> f32 {
    return 0.5 * log2(max(max(dot(dx, dx), dot(dy, dy)), 1e-30));
}

// Half a texel of the coarser of the two mip levels at `level` of an image of `edge` texels.
fn texture_rim(edge: f32, level: f32) -> f32 {
    return min(0.5 * exp2(ceil(level)) / edge, 0.5);
}

{% macro wrap_uv(edge) %}
    let level = max(footprint + {{ log2_of[edge] }}, 0.0);
{% if wraps %}
    let rim = texture_rim({{ edge }}.0, level);
    let uv = vec2f(wrapped(uv_in.x, (reference >> 12u) & 3u, rim), wrapped(uv_in.y, (reference >> 14u) & 3u, rim));
{% else %}
    let uv = uv_in;
{% endif %}
{% endmacro %}
{% for space, edges in (("srgb", srgb_edges), ("linear", linear_edges)) %}
{% if edges %}
fn sample_{{ space }}(reference: u32, uv_in: vec2f, footprint: f32) -> vec4f {
    let layer = reference & 255u;
    {% if edges|length == 1 %}
    {{ wrap_uv(edges[0]) }}
    return textureSampleLevel({{ space }}_{{ edges[0] }}, material_sampler, uv, layer, level);
    {% else %}
    var texel = vec4f(1.0);
    switch (reference >> 8u) & 15u {
        {% for edge in edges %}
        case {{ loop.index0 }}u: {
            {{ wrap_uv(edge) }}
            texel = textureSampleLevel({{ space }}_{{ edge }}, material_sampler, uv, layer, level);
        }
        {% endfor %}
        default: {}
    }
    return texel;
    {% endif %}
}
{% endif %}
{% endfor %}

{% macro textured(slot, space) %}
{% if slot in slots %}
{% if uv_transforms %}
    if material.{{ slot }} != NO_TEXTURE {
        let u = material.{{ slot }}_u;
        let v = material.{{ slot }}_v;
        let moved = vec2f(dot(u.xyz, vec3f(uv, 1.0)), dot(v.xyz, vec3f(uv, 1.0)));
        texel = sample_{{ space }}(material.{{ slot }}, moved, footprint + u.w);
    }
{% else %}
    if material.{{ slot }} != NO_TEXTURE { texel = sample_{{ space }}(material.{{ slot }}, uv, footprint); }
{% endif %}
{% endif %}
{% endmacro %}
fn material_base_color(material: Material, uv: vec2f, footprint: f32) -> vec4f {
    var texel = vec4f(1.0);
    {{ textured("base_color_texture", "srgb") }}
    return vec4f(material.base_color, material.alpha) * texel;
}

// (roughness, metallic)
fn material_roughness_metallic(material: Material, uv: vec2f, footprint: f32) -> vec2f {
    var texel = vec4f(1.0);
    {{ textured("metallic_roughness_texture", "linear") }}
    return vec2f(material.roughness, material.metallic) * texel.yz;
}

fn material_emissive(material: Material, uv: vec2f, footprint: f32) -> vec3f {
    var texel = vec4f(1.0);
    {{ textured("emissive_texture", "srgb") }}
    return material.emissive * texel.rgb;
}

// Tangent-space normal, not normalised; (0, 0, 1) without a normal map.
fn material_normal(material: Material, uv: vec2f, footprint: f32) -> vec3f {
    var texel = vec4f(0.5, 0.5, 1.0, 1.0);
    {{ textured("normal_texture", "linear") }}
    let n = texel.xyz * 2.0 - 1.0;
    return vec3f(n.xy * material.normal_scale, n.z);
}
