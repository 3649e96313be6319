// Surfels of a light's RSM: every texel that meets a surface, lit or black.
{{ use("shaders/octahedral.wgsl") }}
{{ use("techniques/lpv/surfel.wgsl") }}
{% if static_only %}
{{ use("shaders/traits.wgsl") }}

fn traits_at(number: u32) -> u32 { return load_surfaces(surfels.first + number); }
{% endif %}

fn surfel_at(number: u32) -> Surfel {
    let vpl = load_vpls(surfels.first + number);
    return Surfel(vpl.position, unpack_unit_vector(vpl.normal), vpl.area);
}
