// What a cell stores while light travels: numbers that its flux is linear in, in one of three formats.
{{ use("techniques/lpv/storage_scale.wgsl") }}
{% if format == "snorm8" %}
{{ use("techniques/lpv/byte_cells.wgsl") }}
{% endif %}

// The levels lie behind one another, the finest first. A level of `stored` cells has a border of one cell that stays dark,
// so that no step asks where the volume ends; its light has none. Threads in a row belong to one level, in whole workgroups.
struct Level { n: i32, stored: i32, light: i32, first: u32 }

// Dispatches come in rows, as no dimension has more than 65,535 workgroups.
fn thread_of(id: vec3u) -> u32 { return id.x + {{ row }}u * id.y; }

{% macro made(level) %}Level({{ level.n }}, {{ level.stored }}, {{ level.light }}, {{ level.first }}u){% endmacro %}
fn level_of(thread: u32) -> Level {
    {% for level in levels[:-1] %}
    if thread < {{ level.end }}u { return {{ made(level) }}; }
    {% endfor %}
    return {{ made(levels[-1]) }};
}

// The cell number `number` of a level of n^3, x quickest.
fn cell_of(number: u32, n: i32) -> vec3i {
    let edge = u32(n);
    return vec3i(vec3u(number % edge, (number / edge) % edge, number / (edge * edge)));
}

fn stored_index(level: Level, cell: vec3i, channel: u32) -> u32 {
    let edge = level.n + 2;
    return 3u * u32(level.stored + cell.x + 1 + edge * (cell.y + 1 + edge * (cell.z + 1))) + channel;
}

// Where a cell's accumulated light lies.
fn light_index(level: Level, cell: vec3i, channel: u32) -> u32 {
    return 3u * u32(level.light + cell.x + level.n * (cell.y + level.n * cell.z)) + channel;
}

{% if "store" in access %}
fn store_at(index: u32, e: vec4f) {
    cells_out[index] = {% if format == "f16" %}vec2u(pack2x16float(e.xy), pack2x16float(e.zw)){% elif format == "snorm8" %}pack_byte_cell(e, index){% else %}e{% endif %};
}

fn store(level: Level, cell: vec3i, channel: u32, e: vec4f) { store_at(stored_index(level, cell, channel), e); }
{% endif %}

{% if "load" in access %}
fn load_at(index: u32) -> vec4f {
    let stored = cells_in[index];
    return {% if format == "f16" %}vec4f(unpack2x16float(stored.x), unpack2x16float(stored.y)){% elif format == "snorm8" %}unpack_byte_cell(stored){% else %}stored{% endif %};
}

fn load(level: Level, cell: vec3i, channel: u32) -> vec4f { return load_at(stored_index(level, cell, channel)); }
{% endif %}

{% if evaluation == "dominant_lobe" %}
// Sum of max(0, v.m) over the 30 faces; by symmetry it needs the sizes of v's components alone.
fn lobe_normaliser(v: vec3f) -> f32 {
    let side_d = {{ moment_side_d }} * abs(v);
    let side_s = {{ moment_side_s }} * abs(v);
    let sides = max(side_d, side_s.yzx) + max(side_d, side_s.zxy);
    return dot(vec3f({{ moment_far }}), abs(v)) + dot(vec3f(2.0), sides);
}
{% endif %}

// What a cell sends: the numbers that the flux through faces is linear in, but for the clamp.
fn to_emission(c: vec4f) -> vec4f {
    {% if evaluation == "dominant_lobe" %}
    let flux = c.x * {{ 1 / sh_y0 }};
    let size = length(c.yzw);
    if size == 0.0 || flux <= 0.0 { return vec4f(flux * {{ 1 / solid_angle }}, 0.0, 0.0, 0.0); }
    let fraction = min(1.0, {{ sh_cosine_lobe_0 / sh_cosine_lobe_1 }} * size / c.x);
    let lobe_flux = flux * fraction;
    return vec4f((flux - lobe_flux) * {{ 1 / solid_angle }}, c.yzw * (lobe_flux / lobe_normaliser(c.yzw)));
    {% else %}
    return c;
    {% endif %}
}

// The coefficients that led to it.
fn from_emission(e: vec4f) -> vec4f {
    {% if evaluation == "dominant_lobe" %}
    let size = length(e.yzw);
    let lobe_flux = lobe_normaliser(e.yzw);
    let band0 = {{ sh_y0 }} * lobe_flux; // of the lobe; its band 1 is longer by the ratio of a cosine lobe's
    let band1 = e.yzw * ({{ sh_cosine_lobe_1 / sh_cosine_lobe_0 }} * band0 / max(size, 1e-30));
    return vec4f({{ sh_y0 * solid_angle }} * e.x + band0, band1);
    {% else %}
    return e;
    {% endif %}
}
