// For each triangle its box and its place along a Morton curve: 20 bits an axis, in two words of 30.
{{ use("raytracing/world_triangle.wgsl") }}

// Ten bits with two zeros between each.
fn spread(bits: vec3u) -> vec3u {
    var x = (bits | (bits << vec3u(16u))) & vec3u(0x030000ffu);
    x = (x | (x << vec3u(8u))) & vec3u(0x0300f00fu);
    x = (x | (x << vec3u(4u))) & vec3u(0x030c30c3u);
    return (x | (x << vec3u(2u))) & vec3u(0x09249249u);
}

fn interleaved(cell: vec3u) -> u32 {
    let x = spread(cell);
    return x.x << 2u | x.y << 1u | x.z;
}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) thread: vec3u) {
    let i = thread.x;
    if i >= parameters.count { return; }
    let t = world_triangle(ids[i]);
    let low = min(min(t.a, t.b), t.c);
    let high = max(max(t.a, t.b), t.c);
    boxes[2u * i] = vec4u(bitcast<vec3u>(low), i);
    boxes[2u * i + 1u] = vec4u(bitcast<vec3u>(high), i);
    let centre = (0.5 * low + 0.5 * high - frame.low) * frame.scale;
    let cell = vec3u(clamp(centre, vec3f(0.0), vec3f(1048575.0)));
    keys[i] = vec4u(interleaved(cell & vec3u(1023u)), interleaved(cell >> vec3u(10u)), i, 0u);
}
