// Cells' light, W/sr, as filterable volumes, scaled for storage; windows lie behind one another in y.
{{ use("techniques/lpv/storage_scale.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id >= vec3u({{ n }}u, {{ n }}u, {{ n * windows }}u)) { return; }
    let first = 3u * (id.x + {{ n }}u * (id.y + {{ n }}u * id.z));
    let scale = storage_scale(peak[0]);
    let window = id.z / {{ n }}u;
    let texel = vec3u(id.x, id.y + {{ n }}u * window, id.z - {{ n }}u * window);
    {% for channel in ("red", "green", "blue") %}
    textureStore({{ channel }}_out, texel, scale * injected[first + {{ loop.index0 }}u]);
    {% endfor %}
}
