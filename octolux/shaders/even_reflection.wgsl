// What the BRDF reflects of even light: simulator/environment.py, brdf_table.
{% set tables = macros("shaders/tables.wgsl") %}
{{ tables.between_nodes("brdf_table_at", "brdf_table") }}

fn even_reflection(roughness: f32, n_v: f32) -> vec3f {
    return brdf_table_at(vec2f(n_v, roughness) * {{ brdf_table_size }}.0 - 0.5).rgb;
}
