// Ambient visibility from the depth buffer: horizons in slices through the sight line (Jimenez et al. 2016, "Practical
// real-time strategies for accurate indirect occlusion"). Derivations: simulator/gtao.py.
{{ use("shaders/view.wgsl") }}
{{ use("shaders/gbuffer.wgsl") }}
{{ use("frame/gtao_noise.wgsl") }}
{{ use("shaders/blending.wgsl") }}

// How far is looked: within the near radius, which gives way to the far one by its share (simulator/blending.py).
struct Radii { near: f32, far: f32, share: f32 }
{{ use(radius_file) }}

// From the sight line to `horizon`: the integral of cos(t - normal) sin(t).
fn arc(horizon: f32, normal: f32) -> f32 {
    return 0.25 * (cos(normal) - cos(2.0 * horizon - normal) + 2.0 * horizon * sin(normal));
}

// What a pixel shows: its depth, ray and way to the eye, its normals, how it moves from pixel to pixel (metres), and two
// directions across the sight line.
struct Spot {
    pixel: vec2u, depth: f32, ray: vec3f, eye: vec3f, geometric: vec3f, normal: vec3f, to_right: vec3f, down: vec3f,
    across: vec3f, up: vec3f, noise: vec3f,
}

// Ambient visibility within this radius, metres.
fn visible_within(spot: Spot, radius: f32) -> f32 {
    let view = views[0];
    let size = textureDimensions(depth_map);
    var whole = 0.0;
    var open = 0.0;
    {% for slice in range(slices) %}
    {
        let turn = ({{ slice }}.0 + spot.noise.x) * {{ pi / slices }};
        let u = cos(turn) * spot.across + sin(turn) * spot.up;
        let side = cross(spot.eye, u); // normal of the slice
        let crossing = vec2f(dot(spot.down, side), -dot(spot.to_right, side)); // pixels move along it within the slice
        let unsigned_step = normalize(crossing);
        let metres = dot(spot.to_right * unsigned_step.x + spot.down * unsigned_step.y, u);
        let pixel_step = select(-unsigned_step, unsigned_step, metres > 0.0);
        let reach = radius * (1.0 - {{ falloff }} * fract(spot.noise.z + {{ slice / slices }}));
        let pixels = reach / abs(metres);
        let g = vec2f(dot(spot.geometric, u), dot(spot.geometric, spot.eye));
        let n = vec2f(dot(spot.normal, u), dot(spot.normal, spot.eye));
        let g_angle = atan2(g.x, g.y); // of the geometric normal from the sight line, towards u
        let n_angle = atan2(n.x, n.y);
        let weight = max(length(n), 1e-6);
        {% for sign in (1, -1) %}
        {
            let limit = {{ pi / 2 }} + min({{ sign }}.0 * g_angle, {{ sign }}.0 * n_angle);
            let start = fract(spot.noise.y + {{ (2 * slice + loop.index0) * golden % 1 }});
            var highest = cos(limit);
            var last = vec3f(0.0); // the sample before: across and along the sight line (scaled alike), distance
            {% for step in range(steps) %}
            {
                let t = ({{ step }}.0 + start) * {{ 1 / steps }};
                let away = {{ sign }}.0 * max(pixels * t, 1.0) * pixel_step;
                let at = vec2i(floor(vec2f(spot.pixel) + 0.5 + away));
                let there = textureLoad(depth_map, at).x;
                let moved = vec2f(at) - vec2f(spot.pixel);
                let d = (there - spot.depth) * spot.ray
                    + moved.x * (view.origin_dx + there * view.direction_dx)
                    + moved.y * (view.origin_dy + there * view.direction_dy);
                // Moved into the slice along the tangent plane, above which its height stays, and abreast of where it is.
                let aside = dot(d, u);
                let place = vec2f(aside * g.y, dot(d, spot.geometric) - aside * g.x);
                let distance = select(1e30, length(d), there > 0.0 && all(vec2u(at) < size));
                let within = distance < reach;
                let cosine = place.y * inverseSqrt(dot(place, place));
                highest = select(highest, max(highest, cosine), within);
                // Straight from the sample before to one a little beyond the radius: cut at the radius.
                let leaves = last.z < reach && !within && distance < {{ 1 + beyond / steps }} * reach;
                let share = (reach - last.z) / (distance - last.z);
                let cut = mix(last.xy, place, share);
                highest = select(highest, max(highest, cut.y * inverseSqrt(dot(cut, cut))), leaves);
                last = vec3f(place, distance);
            }
            {% endfor %}
            whole += weight * arc(limit, {{ sign }}.0 * n_angle);
            open += weight * arc(min(limit, acos(min(highest, 1.0))), {{ sign }}.0 * n_angle);
        }
        {% endfor %}
    }
    {% endfor %}
    return select(1.0, saturate(open / whole), spot.depth > 0.0 && whole > 0.0);
}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(visibility_out)) { return; }
    let pixel = min({{ resolution }}u * id.xy + {{ resolution // 2 }}u, textureDimensions(depth_map) - 1u);
    let depth = textureLoad(depth_map, pixel).x;
    let view = views[0];
    let ray = view_ray(view, vec2f(pixel) + 0.5);
    let eye = -normalize(ray.direction);
    let s = unpack_surface(textureLoad(surface_map, pixel));
    let normal = select(s.geometric_normal, s.normal, dot(s.normal, eye) > 0.0);
    let to_right = view.origin_dx + depth * view.direction_dx;
    let down = view.origin_dy + depth * view.direction_dy;
    {% if filtered %}
    let noise = tile_noise(id.xy);
    {% else %}
    let noise = vec3f(0.5);
    {% endif %}
    let across = normalize(to_right - eye * dot(to_right, eye));
    let spot = Spot(
        pixel, depth, ray.direction, eye, s.geometric_normal, normal, to_right, down, across, cross(eye, across), noise,
    );
    let radii = ao_radii(ray.origin + depth * ray.direction, s.geometric_normal);
    // Of a single radius that changes, whole pixels would come and go.
    var seen = 1.0;
    for (var far = false; true; far = true) {
        let found = visible_within(spot, select(radii.near, radii.far, far));
        seen = select(found, mix(found, seen, moved_share(seen, found, radii.share)), far);
        if far || radii.share == 1.0 || depth <= 0.0 { break; }
    }
    {% if filtered %}
    textureStore(visibility_out, id.xy, vec4f(seen, depth, 0.0, 0.0));
    {% else %}
    textureStore(visibility_out, id.xy, vec4f(seen));
    {% endif %}
}
