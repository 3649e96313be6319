// Numbers of bricks: of each node that of its first, << 6, with its ways; of each brick its node, << 3, with its way.

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let node = id.x + {{ row }}u * id.y;
    if node >= parameters.count { return; }
    var mask = masks[node];
    var brick = values[node] + totals[node / {{ block }}u];
    ways[node] = (brick << 6u) | mask;
    while mask != 0u {
        owners[brick] = (node << 3u) | firstTrailingBit(mask);
        brick += 1u;
        mask &= mask - 1u;
    }
}
