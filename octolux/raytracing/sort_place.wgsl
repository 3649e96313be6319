// Radix sort, second half: each thread carries its run of keys, in order, to where the prefix sums say.

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let threads = (parameters.count + {{ run - 1 }}u) / {{ run }}u;
    if id.x >= threads { return; }
    let end = min((id.x + 1u) * {{ run }}u, parameters.count);
    for (var i = id.x * {{ run }}u; i < end; i++) {
        let key = keys[i];
        let digit = (select(key.x, key.y, parameters.first == 1u) >> parameters.second) & 255u;
        let slot = digit * threads + id.x;
        let place = counts[slot];
        counts[slot] = place + 1u;
        sorted[place + totals[slot / {{ block }}u]] = key;
    }
}
