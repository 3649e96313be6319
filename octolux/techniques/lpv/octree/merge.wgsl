// Merging by the index volume (OLPV 4.2, eq. 10): each cell of level 0 takes the finest level that has been brought light,
// or the coarsest, into the volumes that the lookup filters. Numbers of level i count 4^-i for sums
// (simulator/lpv/octree.py, `reading_factor`).
{{ use("techniques/lpv/octree/addresses.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) cell: vec3u) {
    if any(cell >= vec3u({{ n }}u)) { return; }
    var level = 0u;
    var factor = 1.0;
    var number = number_of(0u, cell);
    while level < {{ levels - 1 }}u && touched[number] == 0u {
        level += 1u;
        factor *= {{ ratio }};
        number = number_of(level, cell >> vec3u(level));
    }
    textureStore(red_out, cell, factor * light[3u * number]);
    textureStore(green_out, cell, factor * light[3u * number + 1u]);
    textureStore(blue_out, cell, factor * light[3u * number + 2u]);
}
