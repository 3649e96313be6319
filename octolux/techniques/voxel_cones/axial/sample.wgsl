// What is met around a place of a node: what the three ways that look against `direction` send, and what faces there.
// What one way sends, and what faces there.
fn read_way(node: Node, way: u32, scales: u32, within: vec3f, over: vec3f) -> vec4f {
    let brick = brick_of_way((node.first << 6u) | node.ways, way);
    let texel = vec3f(brick_texel(select(brick, 0u, brick == NO_NODE))) + within;
    let found = textureSampleLevel(bricks, brick_sampler, over * texel, 0.0);
    let scale = scale_of((scales >> (8u * (way >> 1u))) & 255u);
    return select(vec4f(scale * found.rgb, found.a), vec4f(0.0), brick == NO_NODE);
}

// The same of those that look against `direction`, across each axis times its part of it.
fn read_against(number: u32, place: Place, direction: vec3f) -> array<vec4f, 3> {
    let node = load_nodes(number);
    let over = 1.0 / vec3f(textureDimensions(bricks));
    var found: array<vec4f, 3>;
    {% for axis in "xyz" %}
    {
        let up = direction.{{ axis }} < 0.0;
        let way = {{ 2 * loop.index0 }}u + select(1u, 0u, up);
        let scales = select(node.scales_down, node.scales_up, up);
        found[{{ loop.index0 }}] = abs(direction.{{ axis }}) * read_way(node, way, scales, place.within, over);
    }
    {% endfor %}
    return found;
}

fn sample_node(number: u32, place: Place, direction: vec3f) -> vec4f {
    let found = read_against(number, place, direction);
    return found[0] + found[1] + found[2];
}

fn facing_node(number: u32, place: Place, direction: vec3f) -> vec3f {
    let found = read_against(number, place, direction);
    return vec3f(found[0].a, found[1].a, found[2].a);
}
