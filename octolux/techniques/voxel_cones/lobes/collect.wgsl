// From the fixed-point sums of a group of lights to light and its moment, as axial/collect.wgsl. A thread for each of the
// eight voxels of a brick's node; in the first of a node's bricks are sums of light, in the second those of its moment.
{{ use("techniques/voxel_cones/bricks/bright.wgsl") }}
{{ use("techniques/voxel_cones/bricks/touch.wgsl") }}
{{ use("techniques/voxel_cones/lobes/moment.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + {{ row }}u * id.y;
    if index >= 8u * injected.count { return; }
    let own = 8u * injected.before + index;
    let place = 8u * injected.first + index;
    let owner = owners[place >> 3u];
    if (owner & 7u) == 2u { return; }
    let directed = (owner & 7u) == 1u;
    let words = vec3u(sums[3u * index], sums[3u * index + 1u], sums[3u * index + 2u]);
    {% for channel in range(3) %}
    sums[3u * index + {{ channel }}u] = 0u;
    {% endfor %}
    let added = select(vec3f(words) * injected.to_light, vec3f(bitcast<vec3i>(words)) * injected.to_moment, directed);
    let before = select(unpack_bright(fresh[own]), unpack_moment(fresh[own]), directed);
    let sum = added + select(before, vec3f(0.0), injected.group == 0u);
    let packed = select(pack_bright(sum), pack_moment(sum), directed);
    fresh[own] = packed;
    if injected.last == 1u && light[place] != packed {
        light[place] = packed;
        touch(owner >> 3u, 0u, 0u);
    }
}
