// Light of a flat quadrilateral by linearly transformed cosines, unshadowed; the reference is simulator/ltc.py.
// Needs ltc_table, brdf_table and area_lights.
{{ use("shaders/brdf.wgsl") }}
{{ use("shaders/even_reflection.wgsl") }}
{% set tables = macros("shaders/tables.wgsl") %}
{{ tables.between_nodes("ltc_table_at", "ltc_table") }}

// A surface's specular lobe towards the eye. x, y, z: its axes in the world, the middle one along the surface. widths: a, c
// and d of its matrix. albedo: what it reflects of even light where Fresnel is 1, over how much of it is above the horizon.
struct Lobe { x: vec3f, y: vec3f, z: vec3f, widths: vec3f, albedo: f32 }

fn specular_lobe(s: Surface, to_eye: vec3f) -> Lobe {
    let n_v = dot(s.normal, to_eye);
    let cosine = clamp(n_v, {{ least_cosine }}, 1.0);
    let sine = sqrt(1.0 - cosine * cosine);
    let roughness = max(s.roughness, {{ min_roughness }});
    let found = ltc_table_at(vec2f(sqrt(1.0 - cosine), roughness) * {{ ltc_table_size - 1 }}.0);
    let widths = found.xyz * (roughness * roughness) / vec3f(1.0, 1.0, cosine);
    let turned = sqrt(1.0 - found.w * found.w);
    // Where the eye looks straight down the lobe is round, and any direction along the surface will do.
    var along = to_eye - n_v * s.normal;
    let across = cross(s.normal, select(vec3f(0.0, 1.0, 0.0), vec3f(1.0, 0.0, 0.0), abs(s.normal.x) < 0.5));
    along = normalize(select(along, across, dot(along, along) < 1e-10));
    let z = vec2f(cosine * found.w - sine * turned, cosine * turned + sine * found.w);
    let horizon = vec2f(widths.z * z.y - widths.x * z.x, z.y);
    let above = 0.5 + 0.5 * horizon.y * inverseSqrt(dot(horizon, horizon));
    let even = even_reflection(roughness, max(n_v, 0.0));
    return Lobe(
        z.y * along - z.x * s.normal, cross(s.normal, along), z.x * along + z.y * s.normal, widths,
        (even.x + even.y) / above,
    );
}

// From the world to where the lobe is a cosine about z, and back.
fn to_cosine(lobe: Lobe, p: vec3f) -> vec3f {
    let x = dot(lobe.x, p) / lobe.widths.x;
    return vec3f(x, dot(lobe.y, p) / lobe.widths.y, dot(lobe.z, p) - lobe.widths.z * x);
}
fn from_cosine(lobe: Lobe, q: vec3f) -> vec3f {
    return lobe.widths.x * q.x * lobe.x + lobe.widths.y * q.y * lobe.y + (lobe.widths.z * q.x + q.z) * lobe.z;
}

// From `start` to `start + edge`, as seen from the origin. The edge is kept apart: the difference of two far corners would
// have lost its digits.
struct Side { start: vec3f, edge: vec3f }

// The angle that a side subtends, times the unit normal of the plane through it and the origin. Angle over sine by Heitz and
// Hill's rational function ("Real-time line- and disk-light shading", 2017), which errs by 1.5e-6; of an obtuse angle it is
// pi over the sine, which the normal's length knows better than the cosine, less that of the rest.
fn side_moment(side: Side) -> vec3f {
    let end = side.start + side.edge;
    let normal = cross(side.start, side.edge);
    let lengths = inverseSqrt(max(dot(side.start, side.start) * dot(end, end), 1e-37));
    let cosine = dot(side.start, end) * lengths;
    let x = min(abs(cosine), 1.0);
    let ratio = (0.8543985 + (0.4965155 + 0.0145206 * x) * x) / (3.4175940 + (4.1616724 + x) * x) * lengths;
    let obtuse = 0.5 * inverseSqrt(max(dot(normal, normal), 1e-37)) - ratio;
    return normal * ({{ 2 * pi }} * select(obtuse, ratio, cosine > 0.0));
}

// The part of a side above a plane, by the heights of its ends; of no length where there is none.
fn above_plane(side: Side, from_height: f32, to_height: f32) -> Side {
    let fall = from_height - to_height;
    let crossing = saturate(from_height / select(fall, 1.0, fall == 0.0));
    let first = select(0.0, crossing, from_height < 0.0);
    let last = select(1.0, crossing, to_height < 0.0);
    return Side(side.start + first * side.edge, (last - first) * side.edge);
}

// What is known of a polygon that is cut at a plane side by side: its moment so far, and where its outline enters and leaves
// the space above. A convex outline does each once at most; the side between them closes it.
struct Cut { moment: vec3f, enters: vec3f, leaves: vec3f }

fn with_side(cut: Cut, side: Side, from_height: f32, to_height: f32) -> Cut {
    let kept = above_plane(side, from_height, to_height);
    return Cut(
        cut.moment + side_moment(kept),
        select(cut.enters, kept.start, from_height < 0.0 && to_height >= 0.0),
        select(cut.leaves, kept.start + kept.edge, from_height >= 0.0 && to_height < 0.0),
    );
}
fn closing(cut: Cut) -> Side { return Side(cut.leaves, cut.enters - cut.leaves); }

fn with_moved(cut: Cut, lobe: Lobe, side: Side) -> Cut {
    let moved = Side(to_cosine(lobe, side.start), to_cosine(lobe, side.edge));
    return with_side(cut, moved, moved.start.z, moved.start.z + moved.edge.z);
}

// Radiance towards the eye.
fn area_light_radiance(light: AreaLight, position: vec3f, to_eye: vec3f, s: Surface, lobe: Lobe) -> TwoLobes {
    let nothing = Cut(vec3f(0.0), vec3f(0.0), vec3f(0.0));
    var cosine = nothing; // the diffuse lobe, cut at the surface's horizon
    var moved = nothing; // the specular, cut there too, moved, and cut at the cosine's horizon
    // Angles do not change with the scale; at that of 1 no square leaves float32, however far the light and smooth the surface.
    let first = light.corner - position;
    let third = first + light.edge0 + light.edge1;
    let scale = inverseSqrt(max(dot(first, first) + dot(third, third), 1e-37));
    let corner0 = scale * first;
    let edge0 = scale * light.edge0;
    let edge1 = scale * light.edge1;
    let edge2 = scale * light.edge2;
    let corner1 = corner0 + edge0;
    let corner2 = corner1 + edge1;
    let corner3 = corner2 + edge2;
    let edge3 = -(edge0 + edge1 + edge2);
    let heights = vec4f(dot(s.normal, corner0), dot(s.normal, corner1), dot(s.normal, corner2), dot(s.normal, corner3));
    {% for i in range(4) %}
    let side{{ i }} = Side(corner{{ i }}, edge{{ i }});
    cosine = with_side(cosine, side{{ i }}, heights[{{ i }}], heights[{{ (i + 1) % 4 }}]);
    moved = with_moved(moved, lobe, above_plane(side{{ i }}, heights[{{ i }}], heights[{{ (i + 1) % 4 }}]));
    {% endfor %}
    let towards = cosine.moment + side_moment(closing(cosine));
    moved = with_moved(moved, lobe, closing(cosine));
    let taken = moved.moment + side_moment(closing(moved));
    let irradiance = max(0.5 * dot(s.normal, towards), 0.0);
    let specular = max({{ 0.5 / pi }} * taken.z, 0.0) * lobe.albedo;
    let diffuse = diffuse_albedo(s) / {{ pi }} * irradiance;
    return TwoLobes(
        light.radiance * (1.0 - fresnel_from(s, to_eye, towards)) * diffuse,
        light.radiance * fresnel_from(s, to_eye, from_cosine(lobe, taken)) * specular,
    );
}

// Fresnel for light from the mean direction of what a lobe takes, of any length.
fn fresnel_from(s: Surface, to_eye: vec3f, towards: vec3f) -> vec3f {
    let half = towards * inverseSqrt(max(dot(towards, towards), 1e-37)) + to_eye;
    return fresnel(s, dot(to_eye, half) * inverseSqrt(max(dot(half, half), 1e-37)));
}
