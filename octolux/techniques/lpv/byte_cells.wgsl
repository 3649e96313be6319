// A cell's channel in one word: three numbers of 8 bits, signed normalised, and a size of 8 bits that they are shares of
// (simulator/lpv/formats.py, which derives it and says why sizes are rounded as they are).

fn size_of(code: i32) -> f32 {
    return bitcast<f32>({{ byte_first }} + {{ byte_step }} * code) - {{ byte_least }};
}

fn code_of(size: f32, index: u32) -> u32 {
    let threshold = fract(f32((index * 0x9E3779B9u) >> 8u) * {{ 2**-24 }} + {{ dither|default(0.0) }});
    let place = f32(bitcast<i32>(size + {{ byte_least }}) - {{ byte_first }}) * {{ 1 / byte_step }};
    let code = clamp(i32(place), 0, 254);
    let low = size_of(code);
    return u32(code) + select(0u, 1u, size - low > threshold * (size_of(code + 1) - low));
}

{% if evaluation == "dominant_lobe" %}
fn largest_of(v: vec3f) -> f32 { return max(abs(v.x), max(abs(v.y), abs(v.z))); }
{% endif %}

fn pack_byte_cell(e: vec4f, index: u32) -> u32 {
    {% if evaluation == "dominant_lobe" %}
    let packed = pack4x8snorm(vec4f(e.yzw / max(4.0 * e.x + largest_of(e.yzw), 1e-30), 0.0));
    let shares = unpack4x8snorm(packed).xyz;
    let flux = {{ solid_angle }} * e.x + lobe_normaliser(e.yzw);
    let size = flux / ({{ solid_angle / 4 }} * (1.0 - largest_of(shares)) + lobe_normaliser(shares));
    {% else %}
    let size = max(e.x, 0.0);
    let packed = pack4x8snorm(vec4f(e.yzw * {{ sh_cosine_lobe_0 / sh_cosine_lobe_1 }} / max(size, 1e-30), 0.0));
    {% endif %}
    return packed | (code_of(size, index) << 24u);
}

fn unpack_byte_cell(word: u32) -> vec4f {
    let size = size_of(i32(word >> 24u));
    let shares = unpack4x8snorm(word).xyz;
    {% if evaluation == "dominant_lobe" %}
    return size * vec4f(0.25 - 0.25 * largest_of(shares), shares);
    {% else %}
    return size * vec4f(1.0, {{ sh_cosine_lobe_1 / sh_cosine_lobe_0 }} * shares);
    {% endif %}
}
