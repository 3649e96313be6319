// The nodes of one level: boxes of their children, in steps of 2^-n of the node's own box (Ylitalo, Karras and Laine
// 2017, section 3): 48 bytes hold four. parameters: first node of the level, and the first node's word in `bvh`.

struct Box { low: vec3f, high: vec3f }

fn triangles_box(first: u32, count: u32) -> Box {
    var low = vec3f({{ largest }});
    var high = -low;
    for (var i = first; i < first + count; i++) {
        for (var k = 0u; k < 3u; k++) {
            let corner = bitcast<vec3f>(bvh[1u + 3u * i + k].xyz);
            low = min(low, corner);
            high = max(high, corner);
        }
    }
    return Box(low, high);
}

fn packed(values: vec4f) -> u32 {
    let v = vec4u(clamp(values, vec4f(0.0), vec4f(255.0))) << vec4u(0u, 8u, 16u, 24u);
    return v.x | v.y | v.z | v.w;
}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= parameters.count { return; }
    let number = parameters.first + id.x;
    let link = links[number];
    var box: array<Box, 4>;
    var low = vec3f({{ largest }});
    var high = -low;
    var child = link.x;
    var triangle = link.y;
    {% for k in range(4) %}
    {
        let kind = (link.z >> {{ 4 * k }}u) & 15u;
        if kind == 8u {
            box[{{ k }}] = Box(boxes[2u * child].xyz, boxes[2u * child + 1u].xyz);
            child++;
        } else {
            box[{{ k }}] = triangles_box(triangle, kind);
            triangle += kind;
        }
        low = min(low, box[{{ k }}].low);
        high = max(high, box[{{ k }}].high);
    }
    {% endfor %}
    boxes[2u * number] = vec4f(low, 0.0);
    boxes[2u * number + 1u] = vec4f(high, 0.0);
    // The power of two above a 255th of the extent, by its exponent; the inverse is exact.
    let exponent = clamp((bitcast<vec3u>((high - low) / 255.0) >> vec3u(23u)) + 1u, vec3u(1u), vec3u(253u));
    let steps = bitcast<vec3f>((254u - exponent) << vec3u(23u));
    let word = parameters.second + 3u * number;
    bvh[word] = vec4u(
        bitcast<vec3u>(low), exponent.x | exponent.y << 8u | exponent.z << 16u | (link.z & 255u) << 24u,
    );
    bvh[word + 1u] = vec4u(
        (parameters.second + 3u * link.x) | (link.z >> 8u) << 24u, 1u + 3u * link.y,
        {% for axis in "xy" %}
        packed(floor((vec4f({% for k in range(4) %}box[{{ k }}].low.{{ axis }}{{ ", " if k < 3 }}{% endfor %}) - low.{{ axis }}) * steps.{{ axis }})),
        {% endfor %}
    );
    bvh[word + 2u] = vec4u(
        packed(floor((vec4f({% for k in range(4) %}box[{{ k }}].low.z{{ ", " if k < 3 }}{% endfor %}) - low.z) * steps.z)),
        {% for axis in "xyz" %}
        packed(ceil((vec4f({% for k in range(4) %}box[{{ k }}].high.{{ axis }}{{ ", " if k < 3 }}{% endfor %}) - low.{{ axis }}) * steps.{{ axis }})),
        {% endfor %}
    );
}
