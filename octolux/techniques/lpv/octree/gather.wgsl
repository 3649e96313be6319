// Gathering (simulator/lpv/gathering.py): what a cell receives from all others, by the inverse square, from nodes as large
// as their distance allows, through the geometry volume.
//
// A workgroup has a block of 4^3 cells, of which those are done that surfaces are looked up in and that have no light
// yet. They read much the same nodes, which the workgroup first lists, level by level: no thread walks the octree, none
// waits for others at a branch, and the order of the sum is always the same. Loops end at their end, as a software
// adapter otherwise runs their bodies once more.
{{ use("techniques/lpv/storage_scale.wgsl") }}
{{ use("techniques/lpv/octree/addresses.wgsl") }}
{% if occlusion %}{{ use("techniques/lpv/octree/passing.wgsl") }}{% endif %}

const CANDIDATES = {{ candidates }}u;
const SHARE = {{ (candidates + 63) // 64 }}u; // of each thread
const SIDE = {{ n // 4 }}u;

var<workgroup> wanted: array<atomic<u32>, 2>;
var<workgroup> cells: array<u32, 64>;
var<workgroup> counts: array<u32, 64>;
var<workgroup> listed: array<u32, CANDIDATES>;
var<workgroup> lengths: array<atomic<u32>, {{ levels }}>;

struct Candidate { level: u32, node: vec3i }

// On level 0 all that may be next to the parents of the block's cells, on others the children of what is next to its own.
fn candidate(number: u32, block: vec3i) -> Candidate {
    if number < 512u {
        return Candidate(0u, 4 * block - 2 + vec3i(vec3u(number & 7u, (number >> 3u) & 7u, number >> 6u)));
    }
    let level = 1u + (number - 512u) / 216u;
    let at = (number - 512u) % 216u;
    return Candidate(level, 2 * ((block >> vec3u(level - 1u)) - 1) + vec3i(vec3u(at % 6u, (at / 6u) % 6u, at / 36u)));
}

fn steps_apart(a: vec3i, b: vec3i) -> i32 {
    let d = abs(a - b);
    return max(d.x, max(d.y, d.z));
}

// Whether the block reads the candidate: it is lit, and on levels whose nodes hold the block not next to it.
fn is_read(c: Candidate, block: vec3i) -> bool {
    let edge = i32(edge_of(c.level));
    let inside = all(c.node >= vec3i(0)) && all(c.node < vec3i(edge));
    let held = c.level >= 2u && steps_apart(c.node, block >> vec3u(max(c.level, 2u) - 2u)) <= 1;
    let number = number_of(c.level, vec3u(clamp(c.node, vec3i(0), vec3i(edge - 1))));
    return inside && !held && nodes[3u * number].w != 0u;
}

// Whether the cell reads the node as the level's rule is (simulator/lpv/gathering.py, `takes`).
fn takes(level: u32, node: vec3i, cell: vec3i) -> bool {
    let far = steps_apart(node, cell >> vec3u(1u)) > 1;
    let next = steps_apart(node >> vec3u(1u), cell >> vec3u(1u)) <= 1;
    return level >= 2u || (level == 1u && far) || (level == 0u && next && any(node != cell));
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) thread: u32) {
    let block_number = group.x + {{ row // 64 }}u * group.y;
    let block = vec3i(vec3u(block_number % SIDE, (block_number / SIDE) % SIDE, block_number / (SIDE * SIDE)));
    if thread < 2u { atomicStore(&wanted[thread], 0u); }
    if thread < {{ levels }}u { atomicStore(&lengths[thread], 0u); }
    workgroupBarrier();

    // The cells to do, in order, one for each of the first threads.
    let own = 4 * block + vec3i(vec3u(thread & 3u, (thread >> 2u) & 3u, thread >> 4u));
    let filled_before = filled[2u * block_number + thread / 32u];
    let bit = 1u << (thread % 32u);
    {% if everywhere %}
    let asked_for = true;
    {% else %}
    let asked_for = marks[u32(own.x + {{ n }} * (own.y + {{ n }} * own.z))] == 1u;
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
    var read_bits = 0u;
    if todo > 0u {
        for (var k = 0u; k < SHARE; k++) {
            let number = thread * SHARE + k;
            let c = candidate(min(number, CANDIDATES - 1u), block);
            if number < CANDIDATES && is_read(c, block) { read_bits |= 1u << k; }
        }
    }
    counts[thread] = countOneBits(read_bits);
    workgroupBarrier();
    if todo == 0u { return; }
    var place = 0u;
    for (var k = 0u; k < 64u; k++) { place += select(0u, counts[k], k < thread); }
    for (var k = 0u; k < SHARE; k++) {
        if (read_bits & (1u << k)) != 0u {
            let c = candidate(thread * SHARE + k, block);
            listed[place] = number_of(c.level, vec3u(c.node));
            atomicAdd(&lengths[c.level], 1u);
            place += 1u;
        }
    }
    workgroupBarrier();
    if thread >= todo { return; }

    let chosen = cells[thread];
    let cell = 4 * block + vec3i(vec3u(chosen & 3u, (chosen >> 2u) & 3u, chosen >> 4u));
    let point = vec3f(cell) + 0.5;
    {% for face in range(6) %}
    var face_{{ face }} = vec3f(0.0);
    {% endfor %}
    var k = 0u;
    for (var level = 0u; level < {{ levels }}u; level++) {
        let end = k + atomicLoad(&lengths[level]);
        let edge = edge_of(level);
        let first = first_of(level);
        let size = f32(1u << level);
        if k < end {
            loop {
                let in_level = listed[k] - first;
                let node = vec3i(vec3u(in_level, in_level / edge, in_level / (edge * edge)) % edge);
                let number = 3u * listed[k];
                let about = bitcast<vec4f>(nodes[number]);
                let halves = array<vec4u, 2>(nodes[number + 1u], nodes[number + 2u]);
                let way = point - about.xyz;
                let square = dot(way, way);
                let direction = way * inverseSqrt(max(square, 1e-12));
                var arriving: vec3f;
                {% for channel in range(3) %}
                {% set pair = "halves[%d].%s" % (channel // 2, ("xy", "zw")[channel % 2]) %}
                let lobe_{{ channel }} = vec4f(unpack2x16float({{ pair }}.x), unpack2x16float({{ pair }}.y));
                arriving[{{ channel }}] = lobe_{{ channel }}.w + max(0.0, dot(lobe_{{ channel }}.xyz, direction));
                {% endfor %}
                let counts_here = takes(level, node, cell) && any(arriving > vec3f(0.0));
                var weight = select(0.0, about.w / (square + {{ spread }} * size * size), counts_here);
                {% if occlusion %}
                weight *= passing(point, -direction, select(0.0, sqrt(square), counts_here), size);
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
    let scale = storage_scale(peak[0]);
    {% for face in range(6) %}
    textureStore(cube_out, cell + vec3i(0, 0, {{ face * n }}), vec4f(scale * face_{{ face }}, 1.0));
    {% endfor %}
}
