// Arithmetic to pass the time, for the profiler's comparison of clocks.
@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    var x = values[id.x] + 1.0;
    for (var i = 0u; i < 64u * rounds[0]; i++) { x = fract(x * 1.618034 + 0.5); }
    values[id.x] = x;
}
