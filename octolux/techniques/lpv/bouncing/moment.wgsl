// First moment of what the surfaces in a cell of a level send (gathering/moments.wgsl): they lie at `places`.
fn moment_of(sent: Light, number: u32, cell: vec3i, size: f32) -> vec4f {
    let weight = sent.red.x + sent.green.x + sent.blue.x;
    return vec4f(size * weight * (vec3f(cell) + 0.5 + places[number].xyz), weight);
}
