// Injection (VCT 5.5): each VPL's flux into the voxel that its point lies in, divided among the ways that this voxel faces.
//
// A surface of area A and normal n that reflects flux F has the radiance F / (pi A), and of a voxel's section across an axis
// it takes A |n| / edge^2 there: it sends F n / (pi edge^2) each way, whatever A is. Sums are in fixed point, of F n: whole
// numbers may be added in any order. A way that the voxel does not face, by a shading normal, has its share taken by others.
{{ use("techniques/voxel_cones/light/arrival.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + {{ row }}u * id.y;
    if index >= source.count { return; }
    let vpl = load_vpls(source.first + index);
    let arrival = arrival_of(vpl);
    if arrival.square == 0.0 { return; }
    let flux = source.scale * vpl.flux * inverseSqrt(arrival.square);
    {% for axis in "xyz" %}{% for side in ("up", "down") %}
    {
        let brick = brick_of_way(ways[arrival.node], {{ 2 * "xyz".index(axis) + (side == "down") }}u);
        if arrival.{{ side }}.{{ axis }} > 0.0 && brick - injected.first < injected.count {
            let slot = 3u * (8u * (brick - injected.first) + arrival.corner);
            {% for channel in range(3) %}
            atomicAdd(&sums[slot + {{ channel }}u], u32(round(arrival.{{ side }}.{{ axis }} * flux[{{ channel }}])));
            {% endfor %}
        }
    }
    {% endfor %}{% endfor %}
}
