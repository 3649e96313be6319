// Reflectors of a window's cells that a finer window reaches: theirs and those of their children. Shares of a cross section
// four times as large; the albedo is the mean by shares.

struct Reflectors { xy: vec4f, z: vec4f, tint: vec3f }

fn scaled_at(cell: u32, factor: f32) -> Reflectors {
    let xy = factor * reflectors[3u * cell];
    let z = factor * reflectors[3u * cell + 1u];
    return Reflectors(xy, z, reflectors[3u * cell + 2u].rgb * (dot(xy, vec4f(1.0)) + z.x + z.y));
}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id >= vec3u({{ n // 2 }}u)) { return; }
    let parent = vec3u(windows[{{ level }}].origin / 2 - windows[{{ level + 1 }}].origin) + id;
    let own = {{ (level + 1) * n**3 }}u + parent.x + {{ n }}u * (parent.y + {{ n }}u * parent.z);
    var sum = scaled_at(own, 1.0);
    for (var child = 0u; child < 8u; child++) {
        let at = 2u * id + vec3u(child & 1u, (child >> 1u) & 1u, child >> 2u);
        let one = scaled_at({{ level * n**3 }}u + at.x + {{ n }}u * (at.y + {{ n }}u * at.z), 0.25);
        sum = Reflectors(sum.xy + one.xy, sum.z + one.z, sum.tint + one.tint);
    }
    let all = dot(sum.xy, vec4f(1.0)) + sum.z.x + sum.z.y;
    reflectors[3u * own] = min(sum.xy, vec4f(1.0));
    reflectors[3u * own + 1u] = min(sum.z, vec4f(1.0));
    reflectors[3u * own + 2u] = vec4f(sum.tint / max(all, 1e-20), 0.0);
}
