// The geometry volume in four words a cell: for each axis the strip of its plane (simulator/lpv/strips.py, `Planes.strips` and
// `pack_planes`).

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let number = id.x + {{ row }}u * id.y;
    if number >= {{ cells }}u { return; }
    let share = max(fronts[number].xyz, backs[number].xyz);
    let aside_next = abs(nexts[number].xyz - 0.5);
    let aside_last = abs(lasts[number].xyz - 0.5);
    let along_last = aside_last > aside_next + {{ 0.5 / 32 }};
    let middle = select(nexts[number].xyz, lasts[number].xyz, along_last);
    let widest = 1.0 - 2.0 * select(aside_next, aside_last, along_last);
    let width = max(widest, max(share, vec3f({{ 1 / 32 }})));
    let from_low = clamp(middle - 0.5 * width, vec3f(0.0), 1.0 - width);
    let low = vec3u(floor(32.0 * from_low + 0.5));
    let high = vec3u(floor(32.0 * (from_low + width) + 0.5));
    let density = vec3u(round(32.0 * min(vec3f(1.0), 32.0 * share / vec3f(max(high - low, vec3u(1u))))));
    let place = min(vec3u(32.0 * offsets[number].xyz), vec3u(31u));
    let axis = select(vec3u(0u), vec3u(1u), along_last);
    let words = density | (place << vec3u(6u)) | (low << vec3u(11u)) | (high << vec3u(17u)) | (axis << vec3u(23u));
    packed[number] = vec4u(select(vec3u(0u), words, share > vec3f(0.0)), 0u);
}
