// Marks the voxels that fragments lie in, cut out or not: a bit for each. Or, where they are `listed`, lists the fragments for
// which there is room: triangle, code of the voxel, samples.
{% if near %}
// Of an octree of what moves: first, where parameters.first is 0, what moves, which are parameters.third triangles; then what is
// static in the same nodes, whose bytes are not 0: that marks no new ones.
{% endif %}
{{ use("raytracing/world_triangle.wgsl") }}
{{ use("techniques/voxel_cones/octree/codes.wgsl") }}
{{ use("techniques/voxel_cones/voxels/fragments.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let tile = id.x + {{ row }}u * id.y;
    if tile >= parameters.second { return; }
    let index = triangle_of(tile, parameters.count);
    {% if near %}
    if (index < parameters.third) != (parameters.first == 0u) { return; }
    {% endif %}
    let corners = world_triangle(load_ids(index));
    let t = projected(to_voxels(corners.a), to_voxels(corners.b), to_voxels(corners.c));
    let columns = tile_columns(columns_of(t), tile - load_starts(index));
    var at = vec2u(0u);
    loop {
        let column = columns.first + vec2i(at);
        let voxel = voxel_of(t, column);
        if covered(t, column).samples > 0u && in_cube(voxel) {
            let code = code_of({{ depth }}u, vec3u(voxel));
            {% if listed %}
            let number = atomicAdd(&fragment_count[0], 1u);
            if number < parameters.third { fragments[number] = vec4u(index, code, covered(t, column).samples, 0u); }
            {% elif near %}
            let there = ((atomicLoad(&occupied[code >> 5u]) >> (code & 24u)) & 255u) != 0u;
            if there || parameters.first == 0u { atomicOr(&occupied[code >> 5u], 1u << (code & 31u)); }
            {% else %}
            atomicOr(&occupied[code >> 5u], 1u << (code & 31u));
            {% endif %}
        }
        at.x += 1u;
        let next = at.x == columns.size.x;
        at = select(at, vec2u(0u, at.y + 1u), next);
        if at.y >= columns.size.y { break; }
    }
}
