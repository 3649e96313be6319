// Injection of low-frequency direct light (CLPV 3.1; simulator/lpv/emitted.py): particles, glowing patches, surroundings. A
// thread a record: neighbours in the list rarely share a cell, so that there is nothing to be added up first (inject.wgsl).
{{ use("shaders/octahedral.wgsl") }}
{{ use("shaders/sh.wgsl") }}
{{ use("techniques/lpv/cell_in_grids.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= source.count { return; }
    let record = load_emitted(source.first + id.x);
    let beam = record.beam * unpack_unit_vector(record.axis);
    let cell = {{ "cell_of_grid(id.y, " if every else "finest_cell(" }}record.position, 0.5 * beam);
    if cell == NOWHERE { return; }
    let shape = vec4f(SH_COSINE_LOBE_0, SH_COSINE_LOBE_1 * beam.yzx);
    let flux = record.flux * source.scale;
    {% for channel in range(3) %}
    let c{{ channel }} = vec4i(round(shape * flux[{{ channel }}]));
    {% for k in range(4) %}
    if c{{ channel }}[{{ k }}] != 0 { atomicAdd(&sums[12u * cell + {{ 4 * channel + k }}u], c{{ channel }}[{{ k }}]); }
    {% endfor %}{% endfor %}
}
