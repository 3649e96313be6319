// The baseline of injection: one thread for each VPL, one atomic add for each of its twelve coefficients. Same fixed point
// and same cells as techniques/lpv/inject.wgsl, so that the sums have the same bits.
{{ use("shaders/octahedral.wgsl") }}
{{ use("shaders/sh.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= source.count { return; }
    let vpl = load_vpls(source.first + id.x);
    if all(vpl.flux == vec3f(0.0)) { return; }
    let normal = unpack_unit_vector(vpl.normal);
    let cell = vec3i(floor((vpl.position - grid.origin) / grid.cell_size + 0.5 * normal));
    if any(cell < vec3i(0)) || any(cell >= vec3i(i32(grid.n))) { return; }
    let lobe = sh_cosine_lobe(normal);
    let first = 12u * (u32(cell.x) + grid.n * (u32(cell.y) + grid.n * u32(cell.z)));
    {% for channel in range(3) %}
    {
        let c = vec4i(round(lobe * (vpl.flux[{{ channel }}] * source.scale[{{ channel }}])));
        {% for k in range(4) %}
        atomicAdd(&sums[first + {{ 4 * channel + k }}u], c[{{ k }}]);
        {% endfor %}
    }
    {% endfor %}
}
