// The geometry volume in a word a cell: for each axis five bits of the share, the larger of both sides, and of where its
// plane lies.

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let number = id.x + {{ row }}u * id.y;
    if number >= {{ cells }}u { return; }
    let share = vec3u(round(31.0 * max(fronts[number].xyz, backs[number].xyz)));
    let plane = min(vec3u(32.0 * offsets[number].xyz), vec3u(31u));
    let both = share | (plane << vec3u(5u));
    packed[number] = both.x | (both.y << 10u) | (both.z << 20u);
}
