// Injection (CLPV 3.1): each VPL moved half a cell along its normal becomes a cosine lobe in the cell it is then in.
// Fixed point, so that the sum has the same bits in any order; the scale is simulator/lpv/injection.py's.
//
// Most neighbours of a map lie in one cell. So a thread walks down {{ run }} VPLs of a column, adds up those of two cells,
// and scatters both when it meets a third. That is the end of an inner loop, not a branch in it: a software adapter runs
// a branch for all threads of a vector, taken or not. It also tests at the end of loops, which is cheaper there.
// Threads come in layers, one for each grid.
{{ use("shaders/octahedral.wgsl") }}
{{ use("shaders/sh.wgsl") }}
{{ use("techniques/lpv/cell_in_grids.wgsl") }}
{% if small_objects != "keep" %}
{{ use("techniques/lpv/small_objects.wgsl") }}
{% endif %}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let start = id.x / source.width * ({{ run }}u * source.width) + id.x % source.width;
    if start >= source.count { return; }
    let steps = min({{ run }}u, (source.count - 1u - start) / source.width + 1u);
    var i = 0u;
    loop {
        var one = NOWHERE;
        var other = NOWHERE;
        {% for channel in range(3) %}
        var both{{ channel }} = vec4i(0);
        var first{{ channel }} = vec4i(0);
        {% endfor %}
        {% if moments %}
        var both_places = vec3i(0);
        var first_places = vec3i(0);
        {% endif %}
        loop {
            let number = source.first + start + i * source.width;
            let vpl = load_vpls(number);
            let normal = unpack_unit_vector(vpl.normal);
            let held = held_by(id.y, vpl.position, 0.5 * normal);
            let cell = held.cell;
            let used = cell != NOWHERE && any(vpl.flux != vec3f(0.0));
            one = select(one, cell, used && one == NOWHERE);
            other = select(other, cell, used && cell != one && other == NOWHERE);
            if used && cell != one && cell != other { break; }
            let lobe = sh_cosine_lobe(normal);
            {% if small_objects != "keep" %}
            let flux = select(vec3f(0.0), vpl.flux * source.scale * kept_share(number, cell), used);
            {% else %}
            let flux = select(vec3f(0.0), vpl.flux * source.scale, used);
            {% endif %}
            {% for channel in range(3) %}
            let c{{ channel }} = vec4i(round(lobe * flux[{{ channel }}]));
            both{{ channel }} += c{{ channel }};
            first{{ channel }} += select(vec4i(0), c{{ channel }}, cell == one);
            {% endfor %}
            {% if moments %}
            let weight = SH_COSINE_LOBE_0 * dot(flux, source.to_intensity) * source.moment_scale;
            let moment = vec3i(round(weight * (held.unshifted - 0.5)));
            both_places += moment;
            first_places += select(vec3i(0), moment, cell == one);
            {% endif %}
            i++;
            if i >= steps { break; }
        }
        {% set words = 16 if moments else 12 %}
        if one != NOWHERE {
            {% if moments %}{% for k in range(3) %}
            atomicAdd(&sums[16u * one + {{ 12 + k }}u], first_places[{{ k }}]);
            {% endfor %}{% endif %}
            {% for channel in range(3) %}{% for k in range(4) %}
            atomicAdd(&sums[{{ words }}u * one + {{ 4 * channel + k }}u], first{{ channel }}[{{ k }}]);
            {% endfor %}{% endfor %}
        }
        if other != NOWHERE {
            {% if moments %}{% for k in range(3) %}
            atomicAdd(&sums[16u * other + {{ 12 + k }}u], both_places[{{ k }}] - first_places[{{ k }}]);
            {% endfor %}{% endif %}
            {% for channel in range(3) %}{% for k in range(4) %}
            atomicAdd(&sums[{{ words }}u * other + {{ 4 * channel + k }}u], both{{ channel }}[{{ k }}] - first{{ channel }}[{{ k }}]);
            {% endfor %}{% endfor %}
        }
        if i >= steps { break; }
    }
}
