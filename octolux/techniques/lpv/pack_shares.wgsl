// The geometry volume in four words a cell: for each axis the strip of its plane (simulator/lpv/geometry.py, `Planes.strips` and
// `pack_planes`), five bits each of its density, of where the plane lies, and of the strip's ends, and one for their axis.

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let number = id.x + {{ row }}u * id.y;
    if number >= {{ cells }}u { return; }
    let share = max(fronts[number].xyz, backs[number].xyz);
    if all(share == vec3f(0.0)) {
        packed[number] = vec4u(0u);
        return;
    }
    let aside_next = abs(nexts[number].xyz - 0.5);
    let aside_last = abs(lasts[number].xyz - 0.5);
    let along_last = aside_last >= aside_next;
    let middle = select(nexts[number].xyz, lasts[number].xyz, along_last);
    let width = max(1.0 - 2.0 * max(aside_next, aside_last), max(share, vec3f({{ 1 / 31 }})));
    let from_low = clamp(middle - 0.5 * width, vec3f(0.0), 1.0 - width);
    let low = vec3u(floor(31.0 * from_low + 0.5));
    let high = vec3u(floor(31.0 * (from_low + width) + 0.5));
    let density = vec3u(round(31.0 * min(vec3f(1.0), 31.0 * share / vec3f(high - low))));
    let plane = min(vec3u(32.0 * offsets[number].xyz), vec3u(31u));
    let axis = select(vec3u(0u), vec3u(1u), along_last);
    packed[number] = vec4u(density | (plane << vec3u(5u)) | (low << vec3u(10u)) | (high << vec3u(15u)) | (axis << vec3u(20u)), 0u);
}
