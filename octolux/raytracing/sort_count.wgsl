// Radix sort, first half: how often each thread's run of keys has each digit. counts: [digit][thread].

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let threads = (parameters.count + {{ run - 1 }}u) / {{ run }}u;
    if id.x >= threads { return; }
    for (var digit = 0u; digit < 256u; digit++) { counts[digit * threads + id.x] = 0u; }
    let end = min((id.x + 1u) * {{ run }}u, parameters.count);
    for (var i = id.x * {{ run }}u; i < end; i++) {
        let key = keys[i];
        let digit = (select(key.x, key.y, parameters.first == 1u) >> parameters.second) & 255u;
        counts[digit * threads + id.x] += 1u;
    }
}
