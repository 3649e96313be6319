// From the fixed-point sums of a group of lights to light that voxels of level 0 send, as a share of a unit (bright.wgsl); after
// the last group, where it is other than it was, its node is touched. A thread for each of the eight voxels of a brick's node.
{{ use("techniques/voxel_cones/bricks/bright.wgsl") }}
{{ use("techniques/voxel_cones/bricks/touch.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + {{ row }}u * id.y;
    if index >= 8u * injected.count { return; }
    let own = 8u * injected.before + index;
    var sum = select(unpack_bright(fresh[own]), vec3f(0.0), injected.group == 0u);
    {% for channel in range(3) %}
    sum.{{ "xyz"[channel] }} += f32(sums[3u * index + {{ channel }}u]) * injected.to_light.{{ "xyz"[channel] }};
    sums[3u * index + {{ channel }}u] = 0u;
    {% endfor %}
    let packed = pack_bright(sum);
    let place = 8u * injected.first + index;
    fresh[own] = packed;
    if injected.last == 1u && light[place] != packed {
        light[place] = packed;
        touch(owners[place >> 3u] >> 3u, 0u, 0u);
    }
}
