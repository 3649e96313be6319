// After each light: its fixed-point sums to W/sr, added to the injected light, and zeroed for the next light. Keeps the
// largest band-0 coefficient (its bits order like integers, as it is never negative).

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let cell = id.x;
    if cell >= arrayLength(&injected) / 3u { return; }
    var largest = 0.0;
    for (var channel = 0u; channel < 3u; channel++) {
        let first = 12u * cell + 4u * channel;
        let fixed = vec4i(sums[first], sums[first + 1u], sums[first + 2u], sums[first + 3u]);
        if any(fixed != vec4i(0)) {
            let light = injected[3u * cell + channel] + vec4f(fixed) * source.to_intensity[channel];
            injected[3u * cell + channel] = light;
            largest = max(largest, light.x);
            for (var k = 0u; k < 4u; k++) { sums[first + k] = 0; }
        }
    }
    if largest > 0.0 { atomicMax(&peak[0], bitcast<u32>(largest)); }
}
