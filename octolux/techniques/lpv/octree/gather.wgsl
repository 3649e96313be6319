// Gathering (simulator/lpv/gathering.py): what a cell receives from all others, by the inverse square, from nodes as large
// as their distance allows, through the geometry volume.
{{ use("techniques/lpv/storage_scale.wgsl") }}
{{ use("techniques/lpv/octree/addresses.wgsl") }}

{% if occlusion %}
// Share of light that passes from a node to a point, unit vector `towards` and `distance` away (simulator/lpv/geometry.py).
fn passing(point: vec3f, towards: vec3f, distance: f32, node_size: f32) -> f32 {
    let size = abs(towards);
    let longest = max(max(size.x, size.y), max(size.z, 1e-6));
    let last = distance - max(1.0, 0.5 * node_size) / longest;
    var passed = 1.0;
    var travelled = 1.0 / longest;
    while travelled < last && passed > {{ opaque }} {
        let level = u32(clamp(floor(log2(travelled * {{ 1 / cone_length }})), 0.0, {{ levels - 1 }}.0));
        let width = f32(1u << level);
        let step = width / longest;
        let middle = point + towards * (travelled + 0.5 * step);
        let cell = clamp(vec3i(floor(middle / width)), vec3i(0), vec3i(i32(edge_of(level)) - 1));
        let shares = unpack4x8unorm(geometry[number_of(level, vec3u(cell))]).xyz;
        passed *= 1.0 - min(dot(shares, size) / longest, 1.0);
        travelled += step;
    }
    return passed;
}
{% endif %}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + {{ row }}u * id.y;
    if index >= count[0] { return; }
    let own = receivers[index];
    let cell = vec3i(vec3u(own, own / {{ n }}u, own / {{ n * n }}u) % {{ n }}u);
    let point = vec3f(cell) + 0.5;
    {% for face in range(6) %}
    var face_{{ face }} = vec3f(0.0);
    {% endfor %}
    for (var i = {{ levels - 1 }}; i >= 0; i--) {
        let level = u32(i);
        let edge = i32(edge_of(level));
        let here = cell >> vec3u(level);
        let size = f32(1u << level);
        let spread = {{ spread }} * size * size;
        // Nodes whose parents are next to this cell's parent; the last level has none and is read whole.
        let low = select(2 * ((here >> vec3u(1u)) - 1), vec3i(0), edge == 1);
        for (var p = 0; p < 27; p++) {
            let family = low + 2 * vec3i(p % 3, (p / 3) % 3, p / 9);
            if any(family < vec3i(0)) || any(family >= vec3i(edge)) { continue; }
            if edge > 1 && nodes[4u * number_of(level + 1u, vec3u(family >> vec3u(1u)))].w == 0.0 { continue; }
            for (var child = 0; child < min(8, edge * edge * edge); child++) {
                let node = family + vec3i(child & 1, (child >> 1u) & 1, child >> 2u);
                let away = abs(node - here);
                if level > 0u && max(away.x, max(away.y, away.z)) <= 1 { continue; }
                let number = 4u * number_of(level, vec3u(node));
                let place = nodes[number];
                if place.w == 0.0 { continue; }
                let way = point - place.xyz;
                let square = dot(way, way);
                let direction = way * inverseSqrt(max(square, 1e-12));
                var weight = 1.0 / (square + spread);
                var arriving: vec3f;
                {% for channel in range(3) %}
                let lobe_{{ channel }} = nodes[number + {{ 1 + channel }}u];
                arriving[{{ channel }}] = lobe_{{ channel }}.w + max(0.0, dot(lobe_{{ channel }}.xyz, direction));
                {% endfor %}
                {% if occlusion %}
                if all(arriving == vec3f(0.0)) { continue; }
                weight *= passing(point, -direction, sqrt(square), size);
                {% endif %}
                arriving *= weight;
                {% for axis in "xyz" %}
                face_{{ 2 * loop.index0 }} += max(0.0, -direction.{{ axis }}) * arriving;
                face_{{ 2 * loop.index0 + 1 }} += max(0.0, direction.{{ axis }}) * arriving;
                {% endfor %}
            }
        }
    }
    let scale = storage_scale(peak[0]);
    {% for face in range(6) %}
    textureStore(cube_out, cell + vec3i(0, 0, {{ face * n }}), vec4f(scale * face_{{ face }}, 1.0));
    {% endfor %}
}
