// Prefix sums from sums in blocks and of blocks; behind the last that of all.

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + {{ row }}u * id.y;
    if index > parameters.count { return; }
    let blocks = (parameters.count + {{ block - 1 }}u) / {{ block }}u;
    if index == parameters.count {
        store_starts(index, totals[blocks]);
    } else {
        store_starts(index, values[index] + totals[index / {{ block }}u]);
    }
}
