// Injection (CLPV 3.1): each VPL moved half a cell along its normal becomes a cosine lobe in the cell it is then in.
// Fixed point, so that the sum has the same bits in any order; the scale is simulator/lpv/injection.py's.
//
// Most neighbours of a map lie in one cell. So a thread walks down {{ run }} VPLs of a column, and scatters what it has
// added up when the cell changes. Threads beside one another read VPLs beside one another, and their cells change at
// about the same step: a software adapter then serves several threads with one round of scattering.
{{ use("shaders/octahedral.wgsl") }}
{{ use("shaders/sh.wgsl") }}

const NOWHERE = 0xffffffffu;

{% macro scatter() %}
if current != NOWHERE {
    {% for channel in range(3) %}{% for k in range(4) %}
    atomicAdd(&sums[12u * current + {{ 4 * channel + k }}u], sum{{ channel }}[{{ k }}]);
    {% endfor %}{% endfor %}
}
{% endmacro %}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let start = id.x / source.width * ({{ run }}u * source.width) + id.x % source.width;
    var current = NOWHERE;
    {% for channel in range(3) %}
    var sum{{ channel }} = vec4i(0);
    {% endfor %}
    for (var i = 0u; i < {{ run }}u; i++) {
        let number = start + i * source.width;
        if number >= source.count { break; }
        let vpl = load_vpls(source.first + number);
        let normal = unpack_unit_vector(vpl.normal);
        let place = vec3i(floor((vpl.position - grid.origin) / grid.cell_size + 0.5 * normal));
        let inside = all(place >= vec3i(0)) && all(place < vec3i(i32(grid.n)));
        if inside && any(vpl.flux != vec3f(0.0)) {
            let cell = u32(place.x) + grid.n * (u32(place.y) + grid.n * u32(place.z));
            if cell != current {
                {{ scatter() }}
                current = cell;
                {% for channel in range(3) %}
                sum{{ channel }} = vec4i(0);
                {% endfor %}
            }
            let lobe = sh_cosine_lobe(normal);
            {% for channel in range(3) %}
            sum{{ channel }} += vec4i(round(lobe * (vpl.flux[{{ channel }}] * source.scale[{{ channel }}])));
            {% endfor %}
        }
    }
    {{ scatter() }}
}
