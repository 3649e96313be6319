// What is met around a place of a node: what voxels send along -`direction`, and what faces against it
// (simulator/voxels/lobes.py, `LobeVoxels`).

// What goes +x, +y, +z of a voxel's light, and -x, -y, -z, for what faces there; all together is 1 (`shares_of_ways`).
// light: mean vector of the ways to where light comes from.
struct Shares { up: vec3f, down: vec3f }

fn shares_of_ways(up: vec3f, down: vec3f, light: vec3f) -> Shares {
    let net = up - down;
    let across = dot(net, net) - net * net;
    let received = vec3f(dot(net, light));
    let to_up = (received + down * light) * inverseSqrt(max(across + up * up, vec3f(1e-18)));
    let to_down = (received - up * light) * inverseSqrt(max(across + down * down, vec3f(1e-18)));
    let spread = vec3f(0.25 * max(1.0 - length(light), 0.0));
    let sent_up = up * max(max(to_up, vec3f(0.0)) + spread, vec3f({{ least }}));
    let sent_down = down * max(max(to_down, vec3f(0.0)) + spread, vec3f({{ least }}));
    let over = 1.0 / max(dot(sent_up + sent_down, vec3f(1.0)), 1e-9);
    return Shares(over * sent_up, over * sent_down);
}

fn sample_node(number: u32, place: Place, direction: vec3f) -> vec4f {
    let node = load_nodes(number);
    let over = 1.0 / vec3f(textureDimensions(bricks));
    let texel = vec3f(brick_texel(node.first)) + place.within;
    let light = textureSampleLevel(bricks, brick_sampler, over * texel, 0.0);
    let second = textureSampleLevel(bricks, brick_sampler, over * (texel + vec3f(3.0, 0.0, 0.0)), 0.0);
    let third = textureSampleLevel(bricks, brick_sampler, over * (texel + vec3f(6.0, 0.0, 0.0)), 0.0);
    let up = vec3f(second.zw, third.x);
    let down = third.yzw;
    let moment = (vec3f(light.a, second.xy) - {{ 128 / 255 }}) * {{ 255 / 127 }};
    let shares = shares_of_ways(up, down, moment / max(dot(light.rgb, vec3f({{ 1 / 3 }})), 1e-9));
    let against = direction < vec3f(0.0);
    let share = dot(abs(direction), select(shares.down, shares.up, against));
    let opacity = dot(abs(direction), select(down, up, against));
    return vec4f(scale_of(node.scales_up & 255u) * share * light.rgb, opacity);
}

fn facing_node(number: u32, place: Place, direction: vec3f) -> vec3f {
    let over = 1.0 / vec3f(textureDimensions(bricks));
    let texel = vec3f(brick_texel(load_nodes(number).first)) + place.within;
    let second = textureSampleLevel(bricks, brick_sampler, over * (texel + vec3f(3.0, 0.0, 0.0)), 0.0);
    let third = textureSampleLevel(bricks, brick_sampler, over * (texel + vec3f(6.0, 0.0, 0.0)), 0.0);
    return abs(direction) * select(third.yzw, vec3f(second.zw, third.x), direction < vec3f(0.0));
}
