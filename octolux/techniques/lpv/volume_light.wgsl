// Light in the air of a volume, or of nested ones, for fog: simulator/lpv/lookup.py, `fluence`.
{{ use("shaders/sh.wgsl") }}
{{ use("techniques/lpv/storage_scale.wgsl") }}
{{ use("techniques/lpv/reading.wgsl") }}
{{ use("techniques/lpv/texel.wgsl") }}

fn cell_fluence(c: vec4f) -> f32 {
    let lobe = sh_dominant_lobe(c);
    return lobe.flux * (lobe.fraction + (1.0 - lobe.fraction) * {{ 2 / 3 }});
}

fn window_fluence(window: u32, position: vec3f) -> vec3f {
    let place = texel_at(window, place_at(window, position, vec3f(0.0)));
    let fluence = vec3f(
        cell_fluence(textureSampleLevel(red, volume_sampler, place, 0.0)),
        cell_fluence(textureSampleLevel(green, volume_sampler, place, 0.0)),
        cell_fluence(textureSampleLevel(blue, volume_sampler, place, 0.0)),
    );
    let cell_size = grids[window].cell_size;
    return fluence * (1.0 / (cell_size * cell_size * storage_scale(peak[0])));
}

fn volume_fluence(position: vec3f) -> vec3f {
    {% if windows > 1 %}
    let reading = reading_at(position, vec3f(0.0));
    let next = window_fluence(min(reading.window + 1u, {{ windows - 1 }}u), position);
    let fluence = mix(next, window_fluence(reading.window, position), reading.share);
    {% else %}
    let fluence = window_fluence(0u, position);
    {% endif %}
    return select(vec3f(0.0), fluence, held_at_all(position));
}

fn volume_step(position: vec3f) -> f32 { return grids[reading_at(position, vec3f(0.0)).window].cell_size; }
