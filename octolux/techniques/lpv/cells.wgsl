// What a cell stores while light travels: numbers that its flux is linear in, in one of two formats.
{{ use("techniques/lpv/storage_scale.wgsl") }}

{% if format == "f16" %}
fn store(index: u32, e: vec4f) { cells_out[index] = vec2u(pack2x16float(e.xy), pack2x16float(e.zw)); }
{% else %}
fn store(index: u32, e: vec4f) { cells_out[index] = e; }
{% endif %}

// What a cell sends: the numbers that the flux through faces is linear in, but for the clamp.
fn to_emission(c: vec4f) -> vec4f {
    {% if evaluation == "dominant_lobe" %}
    let flux = c.x * {{ 1 / sh_y0 }};
    let size = length(c.yzw);
    if size == 0.0 || flux <= 0.0 { return vec4f(flux * {{ 1 / solid_angle }}, 0.0, 0.0, 0.0); }
    let fraction = min(1.0, {{ sh_cosine_lobe_0 / sh_cosine_lobe_1 }} * size / c.x);
    // Sum of max(0, d.m) over the 30 faces; by symmetry it needs the sizes of d's components alone.
    let d = abs(c.yzw) * (1.0 / size);
    let side_d = {{ moment_side_d }} * d;
    let side_s = {{ moment_side_s }} * d;
    let sides = max(side_d, side_s.yzx) + max(side_d, side_s.zxy);
    let all_faces = {{ moment_far }} * (d.x + d.y + d.z) + 2.0 * (sides.x + sides.y + sides.z);
    return vec4f(
        flux * (1.0 - fraction) * {{ 1 / solid_angle }},
        c.yzw * (flux * fraction / (size * all_faces)),
    );
    {% else %}
    return c;
    {% endif %}
}
