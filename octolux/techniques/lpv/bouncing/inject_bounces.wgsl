// Adds what surfaces reflect of all bounces to the light of each window's cells, and to its moments. Irradiance is that of the
// last window's cells around a cell's middle which have any.
{{ use("techniques/lpv/bouncing/reflected.wgsl") }}
{{ use("techniques/lpv/bouncing/moment.wgsl") }}

// Fine cells lie close before their surfaces, and would have part of what arrives behind them: what a face receives is read
// as far before it as a cell of the last window lies on average.
fn irradiance_at(middle: vec3f, away: f32, face: u32) -> vec3f {
    let axis = vec3u(face / 2u) == vec3u(0u, 1u, 2u);
    let outward = select(vec3f(0.0), vec3f(select(1.0, -1.0, (face & 1u) == 1u)), axis);
    let place = clamp(middle + away * outward, vec3f(0.5), vec3f({{ n - 0.5 }}));
    let at = (place + vec3f(0.0, 0.0, {{ n }}.0 * f32(face))) * vec3f({{ 1 / n }}, {{ 1 / n }}, {{ 1 / (6 * n) }});
    let found = textureSampleLevel(cube, volume_sampler, at, 0.0);
    return found.rgb / max(found.a, 1e-3);
}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id >= vec3u({{ n }}u, {{ n }}u, {{ n * windows }}u)) { return; }
    let level = id.z / {{ n }}u;
    let local = vec3i(id - vec3u(0u, 0u, level * {{ n }}u));
    var origin = vec3i(0);
    {% for i in range(windows - 1) %}
    origin = select(origin, windows[{{ i }}].origin, level == {{ i }}u);
    {% endfor %}
    let number = id.x + {{ n }}u * (id.y + {{ n }}u * id.z);
    let facing = reflectors[3u * number];
    let facing_z = reflectors[3u * number + 1u];
    if all(facing == vec4f(0.0)) && all(facing_z == vec4f(0.0)) { return; }
    let per_last = 1.0 / f32(1u << ({{ windows - 1 }}u - level)); // this level's cell size over the last one's
    let middle = per_last * (vec3f(origin + local) + 0.5);
    let away = 0.5 - 0.5 * per_last;
    let factor = per_last * per_last / storage_scale(peak[0]);
    let received = Cube(
        mat2x3f(factor * irradiance_at(middle, away, 0u), factor * irradiance_at(middle, away, 1u)),
        mat2x3f(factor * irradiance_at(middle, away, 2u), factor * irradiance_at(middle, away, 3u)),
        mat2x3f(factor * irradiance_at(middle, away, 4u), factor * irradiance_at(middle, away, 5u)),
    );
    let sent = reflected(number, received);
    injected[3u * number] += sent.red;
    injected[3u * number + 1u] += sent.green;
    injected[3u * number + 2u] += sent.blue;
    moments[number] += moment_of(sent, number, origin + local, f32(1u << level));
}
