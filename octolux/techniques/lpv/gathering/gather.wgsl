// Gathering (simulator/lpv/gathering.py): what a cell receives from all others, by the inverse square, from nodes as large
// as their distance allows, through the geometry volume.
//
// A workgroup has a block of 4^3 cells of a window, of which those are done that surfaces are looked up in and that have
// no light yet. They read much the same nodes, which the workgroup first lists, level by level: no thread walks the
// octree, none waits for others at a branch, and the order of the sum is always the same. Loops end at their end, as a
// software adapter otherwise runs their bodies once more.
{{ use("techniques/lpv/storage_scale.wgsl") }}
{{ use("techniques/lpv/gathering/levels.wgsl") }}
{% if occlusion %}{{ use("techniques/lpv/gathering/passing.wgsl") }}{% endif %}

const COARSEST = {{ levels - 1 }}u; // level that is read
const FIRST_OF_COARSEST = {{ candidates - coarsest**3 }}u; // first candidate of that level
const CANDIDATES = {{ candidates }}u;
const SHARE = {{ (candidates + 63) // 64 }}u; // of each thread
const SIDE = {{ n // 4 }}u;
const BLOCKS = {{ (n // 4) ** 3 }}u; // of a window

var<workgroup> wanted: array<atomic<u32>, 2>;
var<workgroup> cells: array<u32, 64>;
var<workgroup> counts: array<u32, 64>;
var<workgroup> listed: array<u32, CANDIDATES>;
var<workgroup> lengths: array<atomic<u32>, {{ levels }}>;

// steps: levels from the block's own to the node's.
struct Candidate { steps: u32, node: vec3i }

// On the block's own level all that may be next to the parents of its cells, on the coarsest all, on others the children of
// what is next to its own. Blocks are counted from the volume's corner, as nodes are.
fn candidate(number: u32, base: u32, block: vec3i) -> Candidate {
    if number < 512u {
        return Candidate(0u, 4 * block - 2 + vec3i(vec3u(number & 7u, (number >> 3u) & 7u, number >> 6u)));
    }
    if number >= FIRST_OF_COARSEST {
        let at = number - FIRST_OF_COARSEST;
        return Candidate(COARSEST - base, vec3i(vec3u(at, at / {{ coarsest }}u, at / {{ coarsest**2 }}u) % {{ coarsest }}u));
    }
    let between = 1u + (number - 512u) / 216u;
    let steps = select({{ levels }}u, between, base + between < COARSEST); // no level, for coarser windows
    let at = (number - 512u) % 216u;
    return Candidate(steps, 2 * ((block >> vec3u(steps - 1u)) - 1) + vec3i(vec3u(at % 6u, (at / 6u) % 6u, at / 36u)));
}

fn steps_apart(a: vec3i, b: vec3i) -> i32 {
    let d = abs(a - b);
    return max(d.x, max(d.y, d.z));
}

// Whether a node's children are kept, and read in its place by cells that it is next to.
fn has_children(level: u32, node: vec3i) -> bool {
    return {{ "level >= WINDOWS || is_kept(level - 1u, 2 * node)" if windows > 1 else "true" }};
}

// Whether the block reads the candidate: it is lit, and on levels whose nodes hold the block not next to it.
fn is_read(c: Candidate, base: u32, block: vec3i) -> bool {
    let level = base + c.steps;
    let kept = level < {{ levels }}u && is_kept(level, c.node);
    let next = c.steps >= 2u && steps_apart(c.node, block >> vec3u(max(c.steps, 2u) - 2u)) <= 1;
    let number = select(0u, number_of(level, c.node), kept);
    return kept && !(next && has_children(level, c.node)) && moments[number].w > 0.0;
}

// Whether the cell reads the node as the level's rule is (simulator/lpv/gathering.py, `takes`).
fn takes(steps: u32, level: u32, node: vec3i, cell: vec3i) -> bool {
    let far = steps_apart(node, cell >> vec3u(1u)) > 1 || !has_children(level, node);
    let next = steps_apart(node >> vec3u(1u), cell >> vec3u(1u)) <= 1;
    return steps >= 2u || (steps == 1u && far) || (steps == 0u && next && any(node != cell));
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) thread: u32) {
    let block_number = group.x + {{ row // 64 }}u * group.y;
    let base = block_number / BLOCKS;
    let in_window = vec3i(vec3u(block_number % SIDE, (block_number / SIDE) % SIDE, (block_number / (SIDE * SIDE)) % SIDE));
    let block = origin_of(base) / 4 + in_window;
    if thread < 2u { atomicStore(&wanted[thread], 0u); }
    if thread < {{ levels }}u { atomicStore(&lengths[thread], 0u); }
    workgroupBarrier();

    // The cells to do, in order, one for each of the first threads.
    let own = 4 * in_window + vec3i(vec3u(thread & 3u, (thread >> 2u) & 3u, thread >> 4u));
    let filled_before = filled[2u * block_number + thread / 32u];
    let bit = 1u << (thread % 32u);
    {% if everywhere %}
    let asked_for = true;
    {% else %}
    let asked_for = marks[base * {{ n**3 }}u + u32(own.x + {{ n }} * (own.y + {{ n }} * own.z))] == 1u;
    {% endif %}
    let own_wanted = (filled_before & bit) == 0u && asked_for;
    if own_wanted { atomicOr(&wanted[thread / 32u], bit); }
    workgroupBarrier();
    let low = atomicLoad(&wanted[0]);
    let high = atomicLoad(&wanted[1]);
    let before = select(countOneBits(low) + countOneBits(high & (bit - 1u)), countOneBits(low & (bit - 1u)), thread < 32u);
    if own_wanted { cells[before] = thread; }
    if thread < 2u { filled[2u * block_number + thread] |= select(low, high, thread == 1u); }
    let todo = countOneBits(low) + countOneBits(high);

    // The nodes to read.
    var read_bits = vec2u(0u); // 2048 candidates, and as many more
    if todo > 0u {
        for (var k = 0u; k < SHARE; k++) {
            let number = thread * SHARE + k;
            let c = candidate(min(number, CANDIDATES - 1u), base, block);
            if number < CANDIDATES && is_read(c, base, block) {
                read_bits |= select(vec2u(1u, 0u), vec2u(0u, 1u), k >= 32u) << vec2u(k % 32u);
            }
        }
    }
    counts[thread] = countOneBits(read_bits.x) + countOneBits(read_bits.y);
    workgroupBarrier();
    if todo == 0u { return; }
    var place = 0u;
    for (var k = 0u; k < 64u; k++) { place += select(0u, counts[k], k < thread); }
    for (var k = 0u; k < SHARE; k++) {
        if ((select(read_bits.x, read_bits.y, k >= 32u) >> (k % 32u)) & 1u) == 1u {
            let c = candidate(thread * SHARE + k, base, block);
            listed[place] = number_of(base + c.steps, c.node);
            atomicAdd(&lengths[c.steps], 1u);
            place += 1u;
        }
    }
    workgroupBarrier();
    if thread >= todo { return; }

    let chosen = cells[thread];
    let local = 4 * in_window + vec3i(vec3u(chosen & 3u, (chosen >> 2u) & 3u, chosen >> 4u));
    let cell = origin_of(base) + local;
    let point = vec3f(cell) + 0.5;
    let per_cell = {{ 1 / unit }} / f32(1u << base); // nodes' places are in cells of the finest level
    {% for face in range(6) %}
    var face_{{ face }} = vec3f(0.0);
    {% endfor %}
    var k = 0u;
    for (var steps = 0u; steps < {{ levels }}u; steps++) {
        let end = k + atomicLoad(&lengths[steps]);
        let level = base + steps;
        let edge = edge_of(level);
        let first = first_of(level);
        let origin = origin_of(level);
        let size = f32(1u << steps);
        let cone_length = select({{ cone_length }}, {{ 2 * cone_length }}, level == COARSEST); // gathering.py, `_received`
        if k < end {
            loop {
                let in_level = listed[k] - first;
                let node = origin + vec3i(vec3u(in_level, in_level / edge, in_level / (edge * edge)) % edge);
                let about = load_nodes(listed[k]);
                let way = point - per_cell * about.place;
                let square = dot(way, way);
                let direction = way * inverseSqrt(max(square, 1e-12));
                var arriving: vec3f;
                {% for channel in range(3) %}
                {% set pair = "about.%s" % ("red_green.xy", "red_green.zw", "blue.xy")[channel] %}
                let lobe_{{ channel }} = vec4f(unpack2x16float({{ pair }}.x), unpack2x16float({{ pair }}.y));
                arriving[{{ channel }}] = lobe_{{ channel }}.w + max(0.0, dot(lobe_{{ channel }}.xyz, direction));
                {% endfor %}
                let counts_here = takes(steps, level, node, cell) && any(arriving > vec3f(0.0));
                var weight = select(0.0, about.weight / (square + {{ spread }} * size * size), counts_here);
                {% if occlusion %}
                let sides = size * (vec3f(node) + select(vec3f(0.0), vec3f(1.0), direction > vec3f(0.0))) - per_cell * about.place;
                let along = abs(direction) > vec3f({{ touches }});
                let rooms = select(vec3f(1e9), sides / select(vec3f(1.0), direction, along), along);
                let cone = Cone(size, min(rooms.x, min(rooms.y, rooms.z)), cone_length);
                weight *= passing(point, -direction, select(0.0, sqrt(square), counts_here), cone, base);
                {% endif %}
                arriving *= weight;
                {% for axis in "xyz" %}
                face_{{ 2 * loop.index0 }} += max(0.0, -direction.{{ axis }}) * arriving;
                face_{{ 2 * loop.index0 + 1 }} += max(0.0, direction.{{ axis }}) * arriving;
                {% endfor %}
                continuing {
                    k += 1u;
                    break if k >= end;
                }
            }
        }
    }
    // Of the cell's own surfaces what arrives on faces beside them (simulator/lpv/gathering.py, `_from_own_cell`).
    let own_number = number_of(base, cell);
    let mine = load_nodes(own_number);
    {% for channel in range(3) %}
    {
        {% set pair = "mine.%s" % ("red_green.xy", "red_green.zw", "blue.xy")[channel] %}
        let lobe = vec4f(unpack2x16float({{ pair }}.x), unpack2x16float({{ pair }}.y));
        let size = length(lobe.xyz);
        let beside = size - lobe.xyz * lobe.xyz / max(size, 1e-20);
        let arrived = mine.weight * {{ side }} * ({{ pi }} * beside + {{ 8 / 3 * pi }} * lobe.w);
        {% for face in range(6) %}
        face_{{ face }}[{{ channel }}] += arrived[{{ face // 2 }}];
        {% endfor %}
    }
    {% endfor %}
    let scale = storage_scale(peak[0]);
    let texel = local + vec3i(0, {{ n }} * i32(base), 0);
    {% for face in range(6) %}
    textureStore(cube_out, texel + vec3i(0, 0, {{ face * n }}), vec4f(scale * face_{{ face }}, 1.0));
    {% endfor %}
}
