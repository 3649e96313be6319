// Injection of low-frequency direct light (CLPV 3.1; simulator/lpv/emitted.py): particles, glowing patches, surroundings. A
// thread a record: neighbours in the list rarely share a cell, so that there is nothing to be added up first (inject.wgsl).
{% if collect %}
// When all records of a group are in the fixed-point sums: to W/sr, added to the light that is there. Few cells have a
// record, so that they are found by the records: of those that share a cell one takes its sum, and leaves 0 to the others
// and to the next group. Keeps the largest band-0 coefficient (its bits order like integers, as it is never negative).
{% else %}
{{ use("shaders/sh.wgsl") }}
{% endif %}
{{ use("shaders/octahedral.wgsl") }}
{{ use("techniques/lpv/cell_in_grids.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= source.count { return; }
    let record = load_emitted(source.first + id.x);
    let beam = record.beam * unpack_unit_vector(record.axis);
    let held = held_by(id.y, record.position, 0.5 * beam);
    let cell = held.cell;
    {% set words = 16 if moments else 12 %}
    if cell == NOWHERE { return; }
    {% if collect %}
    {% for channel in range(3) %}{% for k in range(4) %}
    {
        let sum = atomicExchange(&sums[{{ words }}u * cell + {{ 4 * channel + k }}u], 0);
        if sum != 0 {
            let at = 12u * cell + {{ 4 * channel + k }}u;
            let light = injected[at] + f32(sum) * source.to_intensity[{{ channel }}];
            injected[at] = light;
            {% if k == 0 %}
            if bitcast<u32>(light) > atomicLoad(&peak[0]) { atomicMax(&peak[0], bitcast<u32>(light)); }
            {% endif %}
        }
    }
    {% endfor %}{% endfor %}
    {% if moments %}{% for k in range(3) %}
    let moment_{{ k }} = atomicExchange(&sums[16u * cell + {{ 12 + k }}u], 0);
    if moment_{{ k }} != 0 { moments[4u * cell + {{ k }}u] += f32(moment_{{ k }}) / source.moment_scale; }
    {% endfor %}{% endif %}
    {% else %}
    let shape = vec4f(SH_COSINE_LOBE_0, SH_COSINE_LOBE_1 * beam.yzx);
    let flux = record.flux * source.scale;
    {% for channel in range(3) %}
    let c{{ channel }} = vec4i(round(shape * flux[{{ channel }}]));
    {% for k in range(4) %}
    if c{{ channel }}[{{ k }}] != 0 { atomicAdd(&sums[{{ words }}u * cell + {{ 4 * channel + k }}u], c{{ channel }}[{{ k }}]); }
    {% endfor %}{% endfor %}
    {% if moments %}
    let weight = SH_COSINE_LOBE_0 * dot(flux, source.to_intensity) * source.moment_scale;
    let moment = vec3i(round(weight * (held.unshifted - 0.5)));
    {% for k in range(3) %}
    atomicAdd(&sums[16u * cell + {{ 12 + k }}u], moment[{{ k }}]);
    {% endfor %}{% endif %}
    {% endif %}
}
