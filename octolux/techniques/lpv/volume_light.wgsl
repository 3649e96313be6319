// Light in the air of one volume, for fog: simulator/lpv/lookup.py, `fluence`.
{{ use("shaders/sh.wgsl") }}
{{ use("techniques/lpv/storage_scale.wgsl") }}

fn cell_fluence(c: vec4f) -> f32 {
    let lobe = sh_dominant_lobe(c);
    return lobe.flux * (lobe.fraction + (1.0 - lobe.fraction) * {{ 2 / 3 }});
}

fn volume_fluence(position: vec3f) -> vec3f {
    let place = (position - grid.origin) / (grid.cell_size * f32(grid.n));
    let fluence = vec3f(
        cell_fluence(textureSampleLevel(red, volume_sampler, place, 0.0)),
        cell_fluence(textureSampleLevel(green, volume_sampler, place, 0.0)),
        cell_fluence(textureSampleLevel(blue, volume_sampler, place, 0.0)),
    );
    let inside = all(place >= vec3f(0.0)) && all(place <= vec3f(1.0));
    return fluence * select(0.0, 1.0 / (grid.cell_size * grid.cell_size * storage_scale(peak[0])), inside);
}

fn volume_step(position: vec3f) -> f32 { return grid.cell_size; }
