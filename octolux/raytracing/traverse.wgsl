// Rays through the BVH. Both faces of a triangle are hit, but for `cull_back`, which camera rays set: they pass through
// the back of single-sided materials. Alpha-masked materials are hit where their alpha reaches the cutoff, blended ones
// with a probability equal to it: `alpha_seed` says which of those this ray meets. t counts lengths of `direction`.
// Needs the scene's bind group, and `bvh`.
{% if cut %}
{{ use("shaders/material.wgsl") }}
{% endif %}

// id: as the visibility buffer has it, 0 is nothing. b1, b2: weights of the corners b and c.
struct RayHit { t: f32, id: u32, b1: f32, b2: f32 }

const BVH_LEAF = 0x80000000u;
const BVH_DONE = 0xffffffffu;
// A bound on the error of a plane's distance in boxes and triangles, relative to the coordinates: 2^-24 for each of the
// subtraction of the origin, the multiplication, the addition, in both.
const BVH_ROUNDING = {{ 2.0 ** -21 }};

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

// The axis that the ray runs along most comes last.
fn bvh_turned(v: vec3f, axis: u32) -> vec3f {
    return select(select(v, v.zxy, axis == 1u), v.yzx, axis == 0u);
}

{% macro traverse(any) %}
    let header = bvh[0];
    // An axis across the ray is given a slope that no coordinate is long enough to show.
    let longest = max(max(abs(direction.x), abs(direction.y)), abs(direction.z));
    let flat = abs(direction) < vec3f(1e-15 * longest);
    let inverse = 1.0 / select(direction, vec3f(1e-15 * longest), flat);
    let reach = max(max(abs(origin.x), abs(origin.y)), abs(origin.z)) + bitcast<f32>(header.w);
    let slack = abs(inverse) * (BVH_ROUNDING * reach);
    let backwards = inverse < vec3f(0.0);
    // Triangles: shear that lays the ray along the last axis (Woop, Benthin and Wald 2013, section 3).
    let axis = select(select(2u, 1u, abs(direction.y) == longest), 0u, abs(direction.x) == longest);
    let turned = bvh_turned(direction, axis);
    let shear = vec3f(turned.xy, 1.0) / turned.z;
    var hit = RayHit(t_max, 0u, 0.0, 0.0);
    var stack: array<u32, {{ bvh_stack }}>;
    var depth = 0u;
    var current = header.x;
    {% if cut %}
    // A cut surface is asked for its alpha outside the inner loop, where a software adapter does it for all its lanes at
    // once and not at each step.
    var asked = false;
    var candidate = hit;
    loop {
    asked = false;
    {% endif %}
    loop {
        {% if cut %}
        if depth == BVH_DONE || asked { break; }
        {% else %}
        if depth == BVH_DONE { break; }
        {% endif %}
        if current < BVH_LEAF {
            let w0 = bvh[current];
            let w1 = bvh[current + 1u];
            let w2 = bvh[current + 2u];
            let kinds = w0.w >> 24u | (w1.x >> 24u) << 8u;
            let step = bitcast<vec3f>((vec3u(w0.w, w0.w >> 8u, w0.w >> 16u) & vec3u(255u)) << vec3u(23u)) * inverse;
            let base = (bitcast<vec3f>(w0.xyz) - origin) * inverse;
            let near_base = base - slack;
            let far_base = base + slack;
            let near_q = select(vec3u(w1.zw, w2.x), w2.yzw, backwards);
            let far_q = select(w2.yzw, vec3u(w1.zw, w2.x), backwards);
            let near = max(
                max(near_base.x + step.x * bvh_bytes(near_q.x), near_base.y + step.y * bvh_bytes(near_q.y)),
                max(near_base.z + step.z * bvh_bytes(near_q.z), vec4f(t_min)),
            );
            let far = min(
                min(far_base.x + step.x * bvh_bytes(far_q.x), far_base.y + step.y * bvh_bytes(far_q.y)),
                min(far_base.z + step.z * bvh_bytes(far_q.z), vec4f(hit.t)),
            );
            // Which child it is stands in the lowest bits of how near it is, so that sorting moves one word.
            let there = (near <= far) & ((vec4u(kinds) & vec4u(15u, 240u, 3840u, 61440u)) != vec4u(0u));
            let keys = select(vec4u(0xffffffffu), (bitcast<vec4u>(max(near, vec4f(0.0))) & vec4u(0xfffffffcu)) | vec4u(0u, 1u, 2u, 3u), there);
            let a = min(keys.xz, keys.yw);
            let b = max(keys.xz, keys.yw);
            let first = min(a.x, a.y);
            let last = max(b.x, b.y);
            let m = max(a.x, a.y);
            let n = min(b.x, b.y);
            let second = min(m, n);
            let third = max(m, n);
            let places = ((kinds & 0x7777u) * 0x1110u);
            let children = w1.x & 0xffffffu;
            if last != 0xffffffffu { stack[depth] = bvh_child(last, kinds, places, children, w1.y); depth++; }
            if third != 0xffffffffu { stack[depth] = bvh_child(third, kinds, places, children, w1.y); depth++; }
            if second != 0xffffffffu { stack[depth] = bvh_child(second, kinds, places, children, w1.y); depth++; }
            if first != 0xffffffffu {
                current = bvh_child(first, kinds, places, children, w1.y);
            } else {
                depth--;
                if depth != BVH_DONE { current = stack[depth]; }
            }
        } else {
            let word = current & 0xffffffu;
            let wa = bvh[word];
            let wb = bvh[word + 1u];
            let wc = bvh[word + 2u];
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
            let nearer = t < hit.t || (t == hit.t && wa.w < hit.id);
            {% if not any %}
            // A front face has its corners counter-clockwise; the shear mirrors where the ray runs down its last axis.
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
            current += 3u - (1u << 24u);
            if (current & 0x7f000000u) == 0u {
                depth--;
                if depth != BVH_DONE { current = stack[depth]; }
            }
            {% if any %}
            if hit.id != 0u { depth = BVH_DONE; }
            {% endif %}
        }
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

fn bvh_bytes(q: u32) -> vec4f {
    return vec4f((vec4u(q) >> vec4u(0u, 8u, 16u, 24u)) & vec4u(255u));
}

fn bvh_child(key: u32, kinds: u32, places: u32, children: u32, triangles: u32) -> u32 {
    let k = key & 3u;
    let kind = (kinds >> (4u * k)) & 15u;
    let leaf = BVH_LEAF | kind << 24u | (triangles + 3u * ((places >> (4u * k)) & 15u));
    return select(leaf, children + 3u * k, kind == 8u);
}

fn closest_hit(origin: vec3f, direction: vec3f, t_min: f32, t_max: f32, alpha_seed: u32, cull_back: bool) -> RayHit {
    {{ traverse(false) }}
    return hit;
}

fn any_hit(origin: vec3f, direction: vec3f, t_min: f32, t_max: f32, alpha_seed: u32) -> bool {
    {{ traverse(true) }}
    return hit.id != 0u;
}
