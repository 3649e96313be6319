// The voxels that a node owns from those of its children (simulator/voxels/pyramid.py, VCT 5.4.3): each is made of the
// eight that one child owns.
{{ use("techniques/voxel_cones/octree.wgsl") }}
{{ use("techniques/voxel_cones/opacity.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = 8u * parameters.first + id.x + {{ row }}u * id.y;
    if index >= 8u * (parameters.first + parameters.count) { return; }
    let child = node_of(8u * codes[index >> 3u] + (index & 7u));
    if child == NO_NODE { return; }
    {% for c in range(8) %}
    let o{{ c }} = unpack_opacity(opacity[8u * child + {{ c }}u]);
    {% endfor %}
    {% for axis, step in (("x", 1), ("y", 2), ("z", 4)) %}
    let {{ axis }} = 0.25 * ({% for c in range(8) if (c // step) % 2 == 0 %}{{ " + " if not loop.first }}max(o{{ c }}.{{ axis }}, o{{ c + step }}.{{ axis }}){% endfor %});
    {% endfor %}
    opacity[index] = pack_opacity(vec3f(x, y, z));
}
