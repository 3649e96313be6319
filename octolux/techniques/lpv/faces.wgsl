// What the lower face of each cell across each axis lets through of light along x, y and z (simulator/lpv/geometry.py,
// `face_transmittance`): the blocked shares of the four cells of the geometry volume around it, which lies half a cell aside,
// so that eight of its cells meet at a cell's corners. And, for bounces, what those eight reflect (bounces.py).
//
// Three numbers make a word (thousandths.wgsl): a step loads less than a tenth of what its cells are. Loads are the cost
// here too: a thread walks {{ block[2] }} cells along z, keeps the sums of the layer behind, and does {{ block[0] }} x {{ block[1] }} cells side by side.
{{ use("techniques/lpv/cells.wgsl") }}
{{ use("techniques/lpv/thousandths.wgsl") }}

{% set channels = {"none": "", "mono": "a", "spectral": "rgb"}[bounces] %}
{# What is summed over a layer: `all` four corners of a cell, or the two on its face across x or y. #}
{% set sums = ["blocked_all", "blocked_x", "blocked_y"] %}
{% for channel in channels %}{% set _ = sums.append("up_" ~ channel ~ "_all") %}{% set _ = sums.append("down_" ~ channel ~ "_all") %}{% endfor %}

// Of light along the axis of a face, and along the two others, that sees the face at a slant.
fn blocked_along(straight: f32, across: f32) -> f32 { return min(1.0, (2.0 * across + straight) * {{ 5 ** -0.5 }}); }

{% if channels %}
fn reflected_share(reflecting: vec3f, blocked: vec3f) -> vec3f {
    return select(vec3f(0.0), reflecting / blocked, blocked > vec3f(0.0));
}
{% endif %}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let thread = thread_of(id);
    let level = level_of(thread);
    let number = thread - level.first;
    // There is a face beyond the last cell.
    let blocks = (vec3u(u32(level.n + 1)) + vec3u({{ block[0] - 1 }}u, {{ block[1] - 1 }}u, {{ block[2] - 1 }}u)) / vec3u({{ block|join("u, ") }}u);
    if number >= blocks.x * blocks.y * blocks.z { return; }
    let base = vec3i(vec3u(number % blocks.x, (number / blocks.x) % blocks.y, number / (blocks.x * blocks.y))) * vec3i({{ block|join(", ") }});
    {% for axis in range(2) %}
    {% for i in range(block[axis] + 1) %}
    let {{ "xy"[axis] }}{{ i }} = base.{{ "xy"[axis] }} + {{ i - 1 }};
    let within_{{ "xy"[axis] }}{{ i }} = {{ "xy"[axis] }}{{ i }} >= 0 && {{ "xy"[axis] }}{{ i }} < level.n;
    {% endfor %}
    {% endfor %}
    {% for cell in block_cells %}
    {% for sum in sums %}
    var {{ sum }}_{{ cell|join("") }} = vec3f(0.0);
    {% endfor %}
    {% endfor %}
    var z = base.z - 1;
    loop {
        let within_z = z >= 0 && z < level.n;
        {% for y in range(block[1] + 1) %}
        {% for x in range(block[0] + 1) %}
        {% set at = x ~ "" ~ y %}
        let inside_{{ at }} = within_x{{ x }} && within_y{{ y }} && within_z;
        let from_{{ at }} = u32(select(0, level.light + x{{ x }} + level.n * (y{{ y }} + level.n * z), inside_{{ at }}));
        let shares_{{ at }} = select(vec3f(0.0), shares[from_{{ at }}].xyz, inside_{{ at }});
        {% if channels %}
        let facing_{{ at }} = reflectors[3u * from_{{ at }}];
        let facing_z_{{ at }} = vec2f(reflectors[3u * from_{{ at }} + 1u].x, reflectors[3u * from_{{ at }} + 1u].y);
        let up_{{ at }} = min(vec3f(facing_{{ at }}.yw, facing_z_{{ at }}.y), shares_{{ at }});
        let down_{{ at }} = min(vec3f(facing_{{ at }}.xz, facing_z_{{ at }}.x), shares_{{ at }});
        {% for channel in channels %}
        let albedo_{{ channel }}_{{ at }} = min(1.0, reflectors[3u * from_{{ at }} + 2u].{{ channel }});
        {% endfor %}
        {% endif %}
        {% endfor %}
        {% endfor %}
        {% for cell in block_cells %}
        {% set x, y, key = cell[0], cell[1], cell|join("") %}
        {
            let cell = vec3i(base.x + {{ x }}, base.y + {{ y }}, z);
            let face_x = shares_{{ x }}{{ y }} + shares_{{ x }}{{ y + 1 }};
            let face_y = shares_{{ x }}{{ y }} + shares_{{ x + 1 }}{{ y }};
            let layer = face_x + shares_{{ x + 1 }}{{ y }} + shares_{{ x + 1 }}{{ y + 1 }};
            {% for channel in channels %}
            {% for way in ("up", "down") %}
            let {{ way }}_{{ channel }} = {% for corner in ((0, 0), (1, 0), (0, 1), (1, 1)) %}{% set at = (x + corner[0]) ~ "" ~ (y + corner[1]) %}{{ "" if loop.first else " + " }}{{ way }}_{{ at }} * albedo_{{ channel }}_{{ at }}{% endfor %};
            {% endfor %}
            {% endfor %}
            if z >= base.z && all(cell <= vec3i(level.n)) {
                let of_x = 0.25 * (blocked_x_{{ key }} + face_x);
                let of_y = 0.25 * (blocked_y_{{ key }} + face_y);
                let of_z = 0.25 * blocked_all_{{ key }};
                let at = stored_index(level, cell, 0u);
                faces[at] = pack_passing(vec3f(of_x.x, blocked_along(of_x.x, of_x.y), blocked_along(of_x.x, of_x.z)), of_x.x);
                faces[at + 1u] = pack_passing(vec3f(blocked_along(of_y.y, of_y.x), of_y.y, blocked_along(of_y.y, of_y.z)), of_y.y);
                faces[at + 2u] = pack_passing(vec3f(blocked_along(of_z.z, of_z.x), blocked_along(of_z.z, of_z.y), of_z.z), of_z.z);
            }
            {% if channels %}
            if z >= base.z && all(cell < vec3i(level.n)) {
                let blocked = blocked_all_{{ key }} + layer;
                let own = light_index(level, cell, 0u){% if bounces == "mono" %} / 3u{% endif %};
                {% for channel in channels %}
                reflectances[own + {{ loop.index0 }}u] = vec2u(
                    pack_thousandths(reflected_share(up_{{ channel }}_all_{{ key }} + up_{{ channel }}, blocked)),
                    pack_thousandths(reflected_share(down_{{ channel }}_all_{{ key }} + down_{{ channel }}, blocked)));
                {% endfor %}
            }
            {% endif %}
            blocked_all_{{ key }} = layer;
            blocked_x_{{ key }} = face_x;
            blocked_y_{{ key }} = face_y;
            {% for channel in channels %}
            up_{{ channel }}_all_{{ key }} = up_{{ channel }};
            down_{{ channel }}_all_{{ key }} = down_{{ channel }};
            {% endfor %}
        }
        {% endfor %}
        continuing {
            z++;
            break if z >= base.z + {{ block[2] }} || z > level.n;
        }
    }
}
