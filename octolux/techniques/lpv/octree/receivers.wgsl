// Lists the cells that lookups filter and that have no light yet.

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) cell: vec3u) {
    if any(cell >= vec3u({{ n }}u)) { return; }
    let number = cell.x + {{ n }}u * (cell.y + {{ n }}u * cell.z);
    if filled[number] == 1u { return; }
    {% if everywhere %}
    let wanted = true;
    {% else %}
    var wanted = false;
    for (var k = 0u; k < 8u; k++) {
        let corner = vec3i(cell) - vec3i(i32(k & 1u), i32((k >> 1u) & 1u), i32(k >> 2u));
        if all(corner >= vec3i(0)) {
            wanted = wanted || corners[u32(corner.x + {{ n }} * (corner.y + {{ n }} * corner.z))] == 1u;
        }
    }
    {% endif %}
    if wanted {
        filled[number] = 1u;
        receivers[atomicAdd(&count[0], 1u)] = number;
    }
}
