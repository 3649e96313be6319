// The voxels that a node owns from those of its children (simulator/voxels/pyramid.py, VCT 5.4.3): each is made of the
// eight that one child owns.
{{ use("techniques/voxel_cones/octree/octree.wgsl") }}
{{ use("techniques/voxel_cones/bricks/facing.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = 8u * parameters.first + id.x + {{ row }}u * id.y;
    if index >= 8u * (parameters.first + parameters.count) { return; }
    let child = node_of(8u * codes[index >> 3u] + (index & 7u));
    if child == NO_NODE { return; }
    {% for c in range(8) %}
    let packed_{{ c }} = facing[8u * child + {{ c }}u];
    let up_{{ c }} = unpack_shares(packed_{{ c }}.x);
    let down_{{ c }} = unpack_shares(packed_{{ c }}.y);
    {% endfor %}
    var up = vec3f(0.0);
    var down = vec3f(0.0);
    {% for axis, step in (("x", 1), ("y", 2), ("z", 4)) %}
    {% for c in range(8) if c // step % 2 == 0 %}
    up.{{ axis }} += 0.25 * max(up_{{ c }}.{{ axis }}, up_{{ c + step }}.{{ axis }});
    down.{{ axis }} += 0.25 * max(down_{{ c }}.{{ axis }}, down_{{ c + step }}.{{ axis }});
    {% endfor %}
    {% endfor %}
    facing[index] = vec2u(pack_shares(up), pack_shares(down));
}
