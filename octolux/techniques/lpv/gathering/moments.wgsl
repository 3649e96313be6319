// First moments of the windows' own light: weight times place, and the weight, which is band 0 summed over the channels; those of
// their parents are the sums of theirs. Places are in cells of the finest level from the volume's corner.
{{ use("techniques/lpv/gathering/levels.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id >= vec3u({{ n }}u, {{ n }}u, {{ n * windows }}u)) { return; }
    let level = id.z / {{ n }}u;
    let cell = origin_of(level) + vec3i(id - vec3u(0u, 0u, level * {{ n }}u));
    let number = id.x + {{ n }}u * (id.y + {{ n }}u * id.z);
    let sum = injected[3u * number] + injected[3u * number + 1u] + injected[3u * number + 2u];
    {% if placed %}
    let beside = placed[number].xyz;
    {% else %}
    // Half a cell behind the middle, where surfaces lie on average (simulator/lpv/gathering.py, `first_moments`).
    let beside = {{ -0.25 * 3 ** 0.5 }} * sum.wyz;
    {% endif %}
    let size = f32(1u << level);
    moments[number] = vec4f(size * (sum.x * (vec3f(cell) + 0.5) + beside), sum.x);
}
