// Merging level {{ level }} with what coarser levels have, by how much of its light has arrived: without a border where one
// level ends (against OLPV 6.1's jumps). arrived = 1 - 2 S_k / (S_0 + ... + S_k), at least 0: nothing while the last step
// brings as much as all before it, all when nothing more comes.
{{ use("techniques/lpv/cells.wgsl") }}
{{ use("techniques/lpv/octree/addresses.wgsl") }}

fn last_step(level: Level, cell: vec3i, channel: u32) -> f32 {
    return from_emission(load(level, cell, channel)).x;
}

// `merged` holds no level 0: that goes into the volumes.
fn merged_index(number: u32, channel: u32) -> u32 { return 3u * (number - {{ n**3 }}u) + channel; }

// Between the middles of the coarser level's cells, as a texture unit filters.
fn coarser(cell: vec3u, channel: u32) -> vec4f {
    let place = clamp((vec3f(cell) + 0.5) * 0.5 - 0.5, vec3f(0.0), vec3f({{ edge // 2 - 1 }}.0));
    let low = vec3u(place);
    var sum = vec4f(0.0);
    for (var k = 0u; k < 8u; k++) {
        let high = vec3u(k & 1u, (k >> 1u) & 1u, k >> 2u);
        let weight = select(1.0 - (place - vec3f(low)), place - vec3f(low), high == vec3u(1u));
        let corner = min(low + high, vec3u({{ edge // 2 - 1 }}u));
        let light_of = {% if last %}{{ factor * ratio }} * light[3u * number_of({{ level + 1 }}u, corner) + channel]{% else %}merged[merged_index(number_of({{ level + 1 }}u, corner), channel)]{% endif %};
        sum += weight.x * weight.y * weight.z * light_of;
    }
    return sum;
}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) cell: vec3u) {
    if any(cell >= vec3u({{ edge }}u)) { return; }
    let number = number_of({{ level }}u, cell);
    let level = level_of({{ levels[level].first }}u);
    var last = 0.0;
    var total = 0.0;
    for (var channel = 0u; channel < 3u; channel++) {
        last += last_step(level, vec3i(cell), channel);
        total += light[3u * number + channel].x;
    }
    let arrived = select(0.0, max(0.0, 1.0 - 2.0 * last / total), total > 0.0);
    {% for channel in ("red", "green", "blue") %}
    let {{ channel }} = mix(coarser(cell, {{ loop.index0 }}u), {{ factor }} * light[3u * number + {{ loop.index0 }}u], arrived);
    {% if level == 0 %}
    textureStore({{ channel }}_out, cell, {{ channel }});
    {% else %}
    merged[merged_index(number, {{ loop.index0 }}u)] = {{ channel }};
    {% endif %}
    {% endfor %}
}
