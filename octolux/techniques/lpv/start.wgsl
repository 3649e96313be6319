// Where there is no step: injected light, scaled for storage, is the whole sum and what the cells would send.
{{ use("techniques/lpv/cells.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let thread = thread_of(id);
    let level = level_of(thread);
    let number = thread - level.first;
    if number >= u32(level.n * level.n * level.n) { return; }
    let cell = cell_of(number, level.n);
    let scale = storage_scale(peak[0]);
    {% if marks %}
    var largest = 0.0;
    {% endif %}
    for (var channel = 0u; channel < 3u; channel++) {
        let index = light_index(level, cell, channel);
        let c = injected[index] * scale;
        light[index] = c;
        store(level, cell, channel, to_emission(c));
        {% if marks %}
        largest = max(largest, c.x);
        {% endif %}
    }
    {% if marks %}
    // I_i = i (OLPV 4.2, injection and downsampling); all other entries stay at l - 1, which is 0 here.
    touched[light_index(level, cell, 0u) / 3u] = select(0u, 1u, largest > {{ threshold }});
    {% endif %}
}
