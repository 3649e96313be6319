// Exclusive prefix sums within blocks of {{ block }} elements, in place, and each block's total.
{% set run = block // 256 %}
var<workgroup> partial: array<{{ element }}, 256>;

@compute @workgroup_size(256, 1, 1)
fn main(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let first = group.x * {{ block }}u + lane * {{ run }}u;
    let end = min(first + {{ run }}u, parameters.count);
    var sum = {{ element }}();
    for (var i = first; i < end; i++) {
        let value = values[i];
        values[i] = sum;
        sum += value;
    }
    partial[lane] = sum;
    // Hillis and Steele 1986: after step k each holds the sum of the last 2^k.
    for (var step = 1u; step < 256u; step <<= 1u) {
        workgroupBarrier();
        var before = {{ element }}();
        if lane >= step { before = partial[lane - step]; }
        workgroupBarrier();
        partial[lane] += before;
    }
    workgroupBarrier();
    let before = partial[lane] - sum;
    for (var i = first; i < end; i++) { values[i] += before; }
    if lane == 255u { totals[group.x] = partial[255]; }
}
