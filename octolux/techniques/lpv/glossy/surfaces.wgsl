// Surfaces as reflected rays meet them (simulator/lpv/glossy.py, `surface_light`), in volumes that are filtered, for rays in
// each octant of directions: their radiance times the area that such rays see of them, and that area; and what they cover
// along the three axes. Windows lie behind one another in y, octants in z; the levels
// above the windows behind the last, side by side in x.
{{ use("shaders/sh.wgsl") }}
{{ use("techniques/lpv/storage_scale.wgsl") }}
{{ use("techniques/lpv/gathering/levels.wgsl") }}

struct Areas { upper: vec3f, lower: vec3f }

fn areas_at(cell: u32) -> Areas {
    let xy = reflectors[3u * cell];
    let z = reflectors[3u * cell + 1u];
    return Areas(vec3f(xy.x, xy.z, z.x), vec3f(xy.y, xy.w, z.y));
}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let slot = id.z / {{ n }}u;
    var level = slot;
    {% for k in range(2, used - windows + 1) %}
    level += select(0u, 1u, slot == {{ windows }}u && id.x >= {{ n - 2 * (n // 2**k) }}u);
    {% endfor %}
    let edge = edge_of(level);
    let at = id - vec3u(select(0u, {{ n }}u - 2u * edge, slot == {{ windows }}u), 0u, {{ n }}u * slot);
    if slot >= {{ slots }}u || any(at >= vec3u(edge)) { return; }
    let cell = first_of(level) + at.x + edge * (at.y + edge * at.z);
    {% if used > windows %}
    // Above the windows, of all cells of the last that lie in this one.
    let steps = max(level, {{ windows - 1 }}u) - {{ windows - 1 }}u;
    var areas = Areas();
    var i = 0u;
    loop {
        let side = (1u << steps) - 1u;
        let child = (at << vec3u(steps)) + vec3u(i & side, (i >> steps) & side, i >> (2u * steps));
        let one = areas_at(first_of(level - steps) + child.x + {{ n }}u * (child.y + {{ n }}u * child.z));
        areas = Areas(areas.upper + one.upper, areas.lower + one.lower);
        i += 1u;
        continuing { break if i >= (1u << (3u * steps)); }
    }
    let share = 1.0 / f32(1u << (2u * steps));
    areas = Areas(min(vec3f(1.0), share * areas.upper), min(vec3f(1.0), share * areas.lower));
    {% else %}
    var areas = areas_at(cell);
    {% endif %}
    let red = injected[3u * cell];
    let green = injected[3u * cell + 1u];
    let blue = injected[3u * cell + 2u];
    var area = dot(areas.upper + areas.lower, vec3f(1.0));
    let lobe = sh_dominant_lobe(red + green + blue);
    if area <= 0.0 && lobe.flux > 0.0 {
        let rest = vec3f((1.0 - lobe.fraction) * {{ 1 / 6 }});
        let upper = max(lobe.direction, vec3f(0.0));
        let lower = max(-lobe.direction, vec3f(0.0));
        areas = Areas(lobe.fraction * upper * upper + rest, lobe.fraction * lower * lower + rest);
        area = 1.0;
    }
    let size = f32(1u << level);
    let scale = select(0.0, storage_scale(peak[0]) / (SH_Y0 * {{ pi }} * size * size * area), area > 0.0);
    let radiance = scale * vec3f(red.x, green.x, blue.x);
    let covers = Areas(min(vec3f(1.0), sqrt(area * areas.upper)), min(vec3f(1.0), sqrt(area * areas.lower)));
    let texel = vec3u(id.x, id.y + {{ n }}u * slot, at.z);
    {% for octant in range(8) %}
    {
        // Rays that go upwards see what faces the lower end.
        {% set x, y, z = (("upper", "lower")[octant % 2], ("upper", "lower")[octant // 2 % 2], ("upper", "lower")[octant // 4]) %}
        let seen = areas.{{ x }}.x + areas.{{ y }}.y + areas.{{ z }}.z;
        let at_octant = texel + vec3u(0u, 0u, {{ octant * n }}u);
        textureStore(radiance_out, at_octant, vec4f(seen * radiance, seen));
        textureStore(facing_out, at_octant, vec4f(covers.{{ x }}.x, covers.{{ y }}.y, covers.{{ z }}.z, 0.0));
    }
    {% endfor %}
}
