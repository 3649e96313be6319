// The leaves' light into the volumes that the lookup filters (simulator/lpv/sparse.py, `merge`): cells in a coarse leaf read
// it filtered with what lies beyond it on their side.
{{ use("techniques/lpv/octree/sparse_nodes.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) cell: vec3u) {
    if any(cell >= vec3u({{ n }}u)) { return; }
    let own = leaf_of(cell);
    var red = light[3u * own.slot];
    var green = light[3u * own.slot + 1u];
    var blue = light[3u * own.slot + 2u];
    if own.level > 0u {
        let level = own.level - 1u;
        let child = cell >> vec3u(level);
        let edge = i32(edge_of(level));
        let beyond = vec3u(clamp(vec3i(child) + 2 * vec3i(child & vec3u(1u)) - 1, vec3i(0), vec3i(edge - 1)));
        let leaf = cell >> vec3u(own.level);
        let along = abs((vec3f(cell) + 0.5) / f32(1u << own.level) - (vec3f(leaf) + 0.5));
        red = vec4f(0.0);
        green = vec4f(0.0);
        blue = vec4f(0.0);
        for (var k = 0u; k < 8u; k++) {
            let crossed = (vec3u(k, k >> 1u, k >> 2u) & vec3u(1u)) == vec3u(1u);
            let found = leaf_near(level, select(child, beyond, crossed));
            let shares = select(1.0 - along, along, crossed);
            let factor = shares.x * shares.y * shares.z / f32(1u << (2u * found.level)); // `reading_factor`, of sums
            red += factor * light[3u * found.slot];
            green += factor * light[3u * found.slot + 1u];
            blue += factor * light[3u * found.slot + 2u];
        }
    }
    textureStore(red_out, cell, red);
    textureStore(green_out, cell, green);
    textureStore(blue_out, cell, blue);
}
