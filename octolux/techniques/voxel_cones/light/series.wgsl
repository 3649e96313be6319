// What all further bounces bring over what this one does (simulator/voxels/series.py, `gain`), from sums of what is received
// after this one and the two before.

@compute @workgroup_size(1)
fn main() {
    var low = vec3u(0u);
    var high = vec3u(0u);
    for (var i = 0u; i < {{ sums }}u; i++) {
        low += sums[2u * i].xyz;
        high += sums[2u * i + 1u].xyz;
    }
    let sum = {{ 2.0 ** -6 }} * vec3f(high) + {{ 2.0 ** -22 }} * vec3f(low);
    let brings = sum - select(series[0].sum, vec3f(0.0), vec3<bool>(bounced.number == 0u));
    let before = select(series[0].brings, vec3f(0.0), vec3<bool>(bounced.number < 2u));
    let ratio = select(vec3f(0.0), clamp(brings / max(before, vec3f(1e-30)), vec3f(0.0), vec3f({{ most }})), before > vec3f(0.0));
    series[0] = Series(sum, brings, ratio / (1.0 - ratio));
}
