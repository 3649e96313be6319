// Fog (CLPV 7): single scattering along the line of sight of some pixels. Written is the mean of the fluence (lx or W/m^2)
// along the path, each step weighted by the share of its light that would arrive, and the path's length. Since the
// weights sum to 1 - T, radiance is albedo / (4 pi) * mean * (1 - T): no light is made, whatever the steps.
{{ use("frame/fog_path.wgsl") }}
{{ use("shaders/lights.wgsl") }}
{{ use("frame/fog_light.wgsl") }}
{% if volume %}
{{ use(volume_file) }}
{% endif %}

// Of a block of pixels the nearest or the farthest, in turns like a chessboard's squares: both sides of a silhouette are
// there for its pixels to choose from. Of equals the first and the last, so that on average it is the block's middle.
fn pixel_of(texel: vec2u) -> vec2u {
    {% if resolution == 1 %}
    return texel;
    {% else %}
    let last = textureDimensions(depth_map) - 1u;
    let nearest = ((texel.x + texel.y) & 1u) == 0u;
    var best = texel * {{ resolution }}u;
    var least = 3e38;
    {% for y in range(resolution) %}
    {% for x in range(resolution) %}
    {
        let pixel = min(texel * {{ resolution }}u + vec2u({{ x }}u, {{ y }}u), last);
        let inverse = 1.0 / max(textureLoad(depth_map, pixel, 0).x, 1e-30); // 0 is nothing, far away
        let depth = select(1.0 / inverse, 1e37, inverse > 1e29);
        let rank = select(-depth, depth, nearest);
        best = select(best, pixel, rank < least || (rank == least && !nearest));
        least = min(least, rank);
    }
    {% endfor %}
    {% endfor %}
    return best;
    {% endif %}
}

// Ordered dither: all of 0 to 15 in each 4 x 4 texels, neighbours far apart.
fn order_of(texel: vec2u) -> u32 {
    let a = texel.x ^ texel.y;
    let b = texel.y;
    let order = (a & 1u) << 3u | (b & 1u) << 2u | (a & 2u) | (b & 2u) >> 1u;
    return (order + 7u * fog.sample) & 15u;
}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(fluence_out)) { return; }
    let path = path_of(pixel_of(id.xy));
    let order = order_of(id.xy);
    let jitter = (f32(order) + 0.5) / 16.0;
    let even = path.length / {{ steps }}.0;
    var passed = vec3f(1.0);
    var weight = vec3f(0.0);
    var fluence = vec3f(0.0);
    var depth = 0.0;
    var t = 0.0;
    var number = 0u;
    loop {
        let first = path.start + t;
        var step = even;
        {% if volume %}
        step = fog.step * volume_step(path.origin + first * path.direction);
        {% endif %}
        {% if density %}
        step = min(step, fog.step * medium.cell);
        {% endif %}
        {% if volume or density %}
        step = min(max(step, path.length * {{ 1 / most_steps }}), path.length - t);
        {% endif %}
        let position = path.origin + (first + jitter * step) * path.direction;
        {% if density %}
        let part = step * density_at(position);
        {% else %}
        let part = step;
        {% endif %}
        let share = passed * absorbed(medium.extinction * part);
        let middle = path.origin + (first + 0.5 * step) * path.direction;
        var arriving = lamp_fluence(position, middle, path.direction, step, order, number);
        {% if volume %}
        arriving += volume_fluence(position);
        {% endif %}
        fluence += share * arriving;
        weight += share;
        depth += part;
        passed *= exp(-medium.extinction * part);
        t += step;
        number++;
        continuing {
            {% if volume or density %}
            break if t >= 0.999999 * path.length;
            {% else %}
            break if number == {{ steps }}u;
            {% endif %}
        }
    }
    textureStore(fluence_out, id.xy, vec4f(fluence / max(weight, vec3f(1e-37)), path.length));
    {% if density %}
    textureStore(density_out, id.xy, vec4f(depth / max(path.length, 1e-20)));
    {% endif %}
}
