// After each group of lights: its fixed-point sums to W/sr, added to the injected light, and zeroed for the next group.
// Keeps the largest band-0 coefficient (its bits order like integers, as it is never negative).

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let cell = id.x;
    if cell >= arrayLength(&sums) / {{ 4 if moments else 3 }}u { return; }
    var largest = 0.0;
    for (var channel = 0u; channel < 3u; channel++) {
        let at = {{ 4 if moments else 3 }}u * cell + channel;
        let fixed = sums[at];
        if any(fixed != vec4i(0)) {
            let light = injected[3u * cell + channel] + vec4f(fixed) * source.to_intensity[channel];
            injected[3u * cell + channel] = light;
            largest = max(largest, light.x);
            sums[at] = vec4i(0);
        }
    }
    {% if moments %}
    // Also where all light has been rounded to 0: nothing may be left for the next group.
    let moment = sums[4u * cell + 3u];
    if any(moment != vec4i(0)) {
        moments[cell] += vec4f(moment) / source.moment_scale;
        sums[4u * cell + 3u] = vec4i(0);
    }
    {% endif %}
    // Most cells are below the peak so far, and a read is cheaper than an atomic maximum.
    if bitcast<u32>(largest) > atomicLoad(&peak[0]) { atomicMax(&peak[0], bitcast<u32>(largest)); }
}
