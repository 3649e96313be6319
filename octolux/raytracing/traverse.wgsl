// Rays through the BVH. Both faces of a triangle are hit, but for `cull_back`, which camera rays set: they pass through
// the back of single-sided materials. Alpha-masked materials are hit where their alpha reaches the cutoff, blended ones
// with a probability equal to it: `alpha_seed` says which of those this ray meets. t counts lengths of `direction`; t_min is
// not negative.
// Needs the scene's bind group, and `bvh`.
{% if cut %}
{{ use("shaders/material.wgsl") }}
{% endif %}

// id: as the visibility buffer has it, 0 is nothing. b1, b2: weights of the corners b and c.
struct RayHit { t: f32, id: u32, b1: f32, b2: f32 }

// What waits to be met: the word of a node, or of a leaf's first triangle and how many there are.
const BVH_LEAF = 0x80000000u;
const BVH_ONE = 0x01000000u;
const BVH_WORD = 0x00ffffffu;
const BVH_DONE = 0xffffffffu;
const BVH_MISSED = 0x7fffffff;
// A bound on the error of a plane's distance in boxes and triangles, relative to the coordinates: 2^-24 for each of the
// subtraction of the origin, the multiplication, the addition, in both.
const BVH_ROUNDING = {{ 2.0 ** -21 }};

{% if bvh_counts is defined %}
var<private> bvh_visits: vec2u; // nodes and triangles met so far: for figures
{% endif %}

{% if cut %}
// Whether the surface is there for this ray.
fn bvh_kept(id: u32, b1: f32, b2: f32, alpha_seed: u32) -> bool {
    let item = load_items((id - 1u) >> {{ cluster_bits }}u);
    let corners = load_triangles(item.first_triangle + ((id - 1u) & {{ 2 ** cluster_bits - 1 }}u));
    let material = load_materials(load_instances(item.instance).material);
    let a = load_vertices(corners.a);
    let b = load_vertices(corners.b);
    let c = load_vertices(corners.c);
    let uv = a.uv + b1 * (b.uv - a.uv) + b2 * (c.uv - a.uv);
    var alpha = material_base_color(material, uv, -100.0).a; // mip level 0
    {% if vertex_colors %}
    let roots = vec3f(unpack4x8unorm(a.color).w, unpack4x8unorm(b.color).w, unpack4x8unorm(c.color).w);
    alpha *= dot(roots * roots, vec3f(1.0 - b1 - b2, b1, b2));
    {% endif %}
    {% if blended %}
    if material.alpha_mode == 2u { return bvh_chance(id, alpha_seed) < alpha; }
    {% endif %}
    return alpha >= material.alpha_cutoff;
}
{% endif %}

{% if blended %}
// A number in [0, 1) for each triangle and seed: PCG in two dimensions (Jarzynski and Olano 2020).
fn bvh_chance(id: u32, alpha_seed: u32) -> f32 {
    var v = vec2u(id, alpha_seed) * 1664525u + 1013904223u;
    v.x += v.y * 1664525u;
    v.y += v.x * 1664525u;
    v ^= v >> vec2u(16u);
    v.x += v.y * 1664525u;
    v.y += v.x * 1664525u;
    v ^= v >> vec2u(16u);
    return f32(v.x >> 8u) / 16777216.0;
}
{% endif %}

fn bvh_word(at: u32) -> vec4u {
    return textureLoad(bvh, vec2u(at & {{ 2 ** bvh_row_bits - 1 }}u, at >> {{ bvh_row_bits }}u));
}

// The axis that the ray runs along most comes last.
fn bvh_turned(v: vec3f, axis: u32) -> vec3f {
    return select(select(v, v.zxy, axis == 1u), v.yzx, axis == 0u);
}

// The four boxes of the node `current` (refit_nodes.wgsl): on with the one of the lowest rank that is met, the others wait
// on the stack, the highest lowest. The rank is how near it is.
{% macro meet_boxes(any) %}
            {% if bvh_counts is defined %}
            bvh_visits.x++;
            {% endif %}
            let w0 = bvh_word(current);
            let w1 = bvh_word(current + 1u);
            let w2 = bvh_word(current + 2u);
            let exponents = vec3u(w0.w, w0.w >> 8u, w0.w >> 16u) & vec3u(255u);
            let step = bitcast<vec3f>(exponents << vec3u(23u)) * inverse;
            let base = (bitcast<vec3f>(w0.xyz) - origin) * inverse;
            let near_base = base - slack;
            let far_base = base + slack;
            let lows = vec3u(w1.zw, w2.x);
            let near_q = select(lows, w2.yzw, backwards);
            let far_q = select(w2.yzw, lows, backwards);
            // Distances are compared as integers, which order those alike that are not negative; where the far one is
            // negative the box is missed either way.
            let near = max(
                max(bvh_planes(near_base.x, step.x, near_q.x), bvh_planes(near_base.y, step.y, near_q.y)),
                max(bvh_planes(near_base.z, step.z, near_q.z), nearest),
            );
            let far = min(
                min(bvh_planes(far_base.x, step.x, far_q.x), bvh_planes(far_base.y, step.y, far_q.y)),
                min(bvh_planes(far_base.z, step.z, far_q.z), vec4i(bitcast<i32>(hit.t))),
            );
            let kinds = w0.w >> 24u | (w1.x >> 24u) << 8u;
            let there = (near <= far) & ((vec4u(kinds) & vec4u(15u, 240u, 3840u, 61440u)) != vec4u(0u));
            // Which child it is stands in the lowest bits of its rank, so that sorting moves one word.
            {% if any %}
            // Where any hit will do, the nearest is not the likeliest: first the leaves, which may end the search at once.
            let inner = (vec4u(kinds) & vec4u(8u, 128u, 2048u, 32768u)) != vec4u(0u);
            let ranks = vec4i(0, 4, 8, 12) + select(vec4i(0), vec4i(16), inner);
            {% else %}
            let ranks = near & vec4i(-4);
            {% endif %}
            let keys = select(vec4i(BVH_MISSED), ranks | vec4i(0, 1, 2, 3), there);
            let lesser = min(keys.xz, keys.yw);
            let greater = max(keys.xz, keys.yw);
            let first = min(lesser.x, lesser.y);
            let middle = vec2i(max(lesser.x, lesser.y), min(greater.x, greater.y));
            let second = min(middle.x, middle.y);
            let third = max(middle.x, middle.y);
            let fourth = max(greater.x, greater.y);
            {% for key in ("fourth", "third", "second") %}
            stack[depth] = bvh_child({{ key }}, kinds, w1.x, w1.y);
            depth += select(0u, 1u, {{ key }} != BVH_MISSED);
            {% endfor %}
            let none = first == BVH_MISSED;
            depth -= select(0u, 1u, none);
            current = select(bvh_child(first, kinds, w1.x, w1.y), stack[depth], none);
{% endmacro %}

// The next triangle of the leaf `current`, laid out so that the ray runs from the origin along the last axis (Woop,
// Benthin and Wald 2013, section 3).
{% macro meet_triangle(any) %}
            {% if bvh_counts is defined %}
            bvh_visits.y++;
            {% endif %}
            let word = current & BVH_WORD;
            let wa = bvh_word(word);
            let wb = bvh_word(word + 1u);
            let wc = bvh_word(word + 2u);
            let a = bvh_turned(bitcast<vec3f>(wa.xyz) - origin, axis);
            let b = bvh_turned(bitcast<vec3f>(wb.xyz) - origin, axis);
            let c = bvh_turned(bitcast<vec3f>(wc.xyz) - origin, axis);
            let a2 = a.xy - shear.xy * a.z;
            let b2 = b.xy - shear.xy * b.z;
            let c2 = c.xy - shear.xy * c.z;
            // Products are compared, not subtracted: rounding keeps their order, so that the two triangles at an edge
            // never both lose a ray, and a compiler's fused multiply-add cannot spoil it.
            let p = vec3f(c2.x * b2.y, a2.x * c2.y, b2.x * a2.y);
            let q = vec3f(c2.y * b2.x, a2.y * c2.x, b2.y * a2.x);
            let inside = all(p >= q) | all(p <= q);
            let weights = p - q;
            let sum = weights.x + weights.y + weights.z;
            let t = shear.z * (weights.x * a.z + weights.y * b.z + weights.z * c.z) / sum;
            // Of two at the same distance the one with the lower number, in whatever order they are met.
            let nearer = t < hit.t || (t == hit.t && wa.w < hit.id);
            {% if not any %}
            // The sum has the sign of the winding as the ray's origin sees it, turned round where the ray runs down its
            // axis.
            let behind = (sum * shear.z < 0.0) != ((wb.w & {{ flag_flipped }}u) != 0u);
            let culled = cull_back && (wb.w & {{ flag_single_sided }}u) != 0u && behind;
            {% endif %}
            if inside && sum != 0.0 && t >= t_min && nearer{{ "" if any else " && !culled" }} {
                let met = RayHit(t, wa.w, weights.y / sum, weights.z / sum);
                {% if cut %}
                asked = (wb.w & {{ flag_masked }}u) != 0u;
                if asked { candidate = met; } else { hit = met; }
                {% else %}
                hit = met;
                {% endif %}
            }
            current += 3u - BVH_ONE;
            if current < BVH_LEAF + BVH_ONE {
                depth--;
                current = stack[depth];
            }
            {% if any %}
            if hit.id != 0u { current = BVH_DONE; }
            {% endif %}
{% endmacro %}

{% macro traverse(any) %}
    let header = bvh_word(0);
    // An axis across the ray is given a slope that no coordinate is long enough to show.
    let longest = max(max(abs(direction.x), abs(direction.y)), abs(direction.z));
    let flat = abs(direction) < vec3f(1e-15 * longest);
    let inverse = 1.0 / select(direction, vec3f(1e-15 * longest), flat);
    let reach = max(max(abs(origin.x), abs(origin.y)), abs(origin.z)) + bitcast<f32>(header.w);
    let slack = abs(inverse) * (BVH_ROUNDING * reach);
    let backwards = inverse < vec3f(0.0);
    let nearest = vec4i(bitcast<i32>(max(t_min, 0.0)));
    let axis = select(select(2u, 1u, abs(direction.y) == longest), 0u, abs(direction.x) == longest);
    let turned = bvh_turned(direction, axis);
    let shear = vec3f(turned.xy, 1.0) / turned.z;
    var hit = RayHit(t_max, 0u, 0.0, 0.0);
    var stack: array<u32, {{ bvh_stack }}>;
    stack[0] = BVH_DONE;
    var depth = 1u;
    var current = header.x;
    {% if cut %}
    // A cut surface is asked for its alpha outside the inner loop, where a software adapter does it for all its lanes at
    // once and not at each step.
    var asked = false;
    var candidate = hit;
    loop {
    asked = false;
    {% endif %}
    // Loops end at their end, and nodes have their loop and triangles theirs: a software adapter goes through a loop's
    // whole body once more when the last thread has left it at its beginning, and through all that an `if` guards.
    loop {
        loop {
            if current < BVH_LEAF {
                {{ meet_boxes(any) }}
            }
            continuing { break if current >= BVH_LEAF; }
        }
        loop {
            if current >= BVH_LEAF && current != BVH_DONE {
                {{ meet_triangle(any) }}
            }
            continuing { break if current < BVH_LEAF || current == BVH_DONE{{ " || asked" if cut }}; }
        }
        continuing { break if current == BVH_DONE{{ " || asked" if cut }}; }
    }
    {% if cut %}
    if !asked { break; }
    if bvh_kept(candidate.id, candidate.b1, candidate.b2, alpha_seed) {
        hit = candidate;
        {% if any %}
        break;
        {% endif %}
    }
    }
    {% endif %}
{% endmacro %}

// Distances to planes that lie at four whole numbers of steps, a byte each.
fn bvh_planes(base: f32, step: f32, bytes: u32) -> vec4i {
    let q = vec4f(vec4i((vec4u(bytes) >> vec4u(0u, 8u, 16u, 24u)) & vec4u(255u)));
    return bitcast<vec4i>(base + step * q);
}

// Word of the child that the key names, and for a leaf how many triangles begin there.
fn bvh_child(key: i32, kinds: u32, children: u32, triangles: u32) -> u32 {
    let shift = 4u * (u32(key) & 3u);
    let kind = (kinds >> shift) & 15u;
    let before = (((kinds & 0x7777u) * 0x1110u) >> shift) & 15u; // triangles of the children before it
    let leaf = BVH_LEAF + kind * BVH_ONE + triangles + 3u * before;
    return select(leaf, (children & BVH_WORD) + 3u * (u32(key) & 3u), kind == 8u);
}

fn closest_hit(origin: vec3f, direction: vec3f, t_min: f32, t_max: f32, alpha_seed: u32, cull_back: bool) -> RayHit {
    {{ traverse(false) }}
    return hit;
}

fn any_hit(origin: vec3f, direction: vec3f, t_min: f32, t_max: f32, alpha_seed: u32) -> bool {
    {{ traverse(true) }}
    return hit.id != 0u;
}
