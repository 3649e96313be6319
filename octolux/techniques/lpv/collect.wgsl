// After each group of lights: its fixed-point sums to W/sr, added to the injected light, and zeroed for the next group.
// Keeps the largest band-0 coefficient (its bits order like integers, as it is never negative).

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let cell = id.x;
    if cell >= arrayLength(&sums) / 3u { return; }
    var largest = 0.0;
    for (var channel = 0u; channel < 3u; channel++) {
        let at = 3u * cell + channel;
        let fixed = sums[at];
        if any(fixed != vec4i(0)) {
            let light = injected[at] + vec4f(fixed) * source.to_intensity[channel];
            injected[at] = light;
            largest = max(largest, light.x);
            sums[at] = vec4i(0);
        }
    }
    // Most cells are below the peak so far, and a read is cheaper than an atomic maximum.
    if bitcast<u32>(largest) > atomicLoad(&peak[0]) { atomicMax(&peak[0], bitcast<u32>(largest)); }
}
