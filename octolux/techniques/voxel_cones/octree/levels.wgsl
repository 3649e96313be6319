// From the voxels of a level, by bits, to its nodes and to the voxels of the next level (VCT 5.2.3: flag and subdivide).
// A node owns eight voxels, which are a byte of `occupied`, and its brick has those of its neighbours at its upper sides
// too: it is there where any of these 27 is occupied. So where a node is missing all around it is empty at that side, and
// filtered values go to zero inside the brick: there is no discontinuity like that of figure 5.10.
//
// In an octree of what moves all neighbours of what is occupied have nodes, which hold what is static there; those whose
// bricks are whole are `shown`, and stand for nodes of what is static.
{{ use("techniques/voxel_cones/octree/codes.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let log2_edge = parameters.first; // of the level's nodes
    let level_begin = 1u << (3u * log2_edge); // its first code
    let word = (level_begin >> 2u) + id.x + {{ row }}u * id.y;
    if 4u * word >= 2u * level_begin { return; }
    let voxels = atomicLoad(&occupied[word]);
    if voxels == 0u { return; }
    for (var k = 0u; k < 4u; k++) {
        let own = (voxels >> (8u * k)) & 255u;
        let code = 4u * word + k;
        if own != 0u && code >= level_begin {
            atomicOr(&occupied[code >> 5u], 1u << (code & 31u));
            let cell = cell_of(code);
            {% for corner in corners %}
            if (own & {{ corner.lower }}u) != 0u && all(cell >= vec3u({{ corner.offset }})) {
                let other = code_of(log2_edge, cell - vec3u({{ corner.offset }}));
                atomicOr(&{{ "shown" if neighbours else "nodes" }}[other >> 5u], 1u << (other & 31u));
            }
            {% endfor %}
            {% for offset in neighbours %}
            {
                let at = vec3i(cell) + vec3i({{ offset }});
                if all(at >= vec3i(0)) && all(at < vec3i(1 << log2_edge)) {
                    let other = code_of(log2_edge, vec3u(at));
                    atomicOr(&nodes[other >> 5u], 1u << (other & 31u));
                }
            }
            {% endfor %}
        }
    }
}
