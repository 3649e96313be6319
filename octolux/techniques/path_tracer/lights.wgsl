// Light that reaches a vertex of a path straight from what shines: one shadow ray to a lamp, one to a glowing triangle or area
// light, one to the surroundings, one to a particle light; and the other half of multiple importance sampling, what a reflected ray meets.

fn balance(own: f32, other: f32) -> f32 { return own / (own + other); }

fn visible_between(p: Vertex_, l: vec3f, distance: f32, seed: u32) -> bool {
    let origin = offset_origin(p.position, p.surface.geometric_normal, l);
    return !any_hit(origin, l, 0.0, distance, seed);
}

{% if lamps %}
// Unshadowed light of lamp number `index` reflected to the eye; its direction and distance.
struct Arrival { radiance: vec3f, direction: vec3f, distance: f32 }

fn arrival(p: Vertex_, index: u32) -> Arrival {
    let light = lights[index];
    var l = -light.direction;
    var distance = FAR;
    var illuminance = light.color;
    if index >= {{ directional }}u {
        let to_light = light.position - p.position;
        distance = length(to_light);
        l = to_light / distance;
        illuminance = point_illuminance(light, to_light);
        if index < {{ directional + spots }}u { illuminance *= spot_attenuation(light, l); }
    }
    return Arrival(reflection(p.surface, p.to_eye, l) * illuminance, l, distance);
}

// One lamp, chosen by what each would bring without shadows.
fn lamps_at(p: Vertex_, choice: f32, seed: u32) -> vec3f {
    var total = 0.0;
    for (var i = 0u; i < {{ lamps }}u; i++) { total += dot(arrival(p, i).radiance, {{ luminance }}); }
    if total <= 0.0 { return vec3f(0.0); }
    var left = choice * total;
    var chosen = 0u;
    var share = 0.0;
    for (var i = 0u; i < {{ lamps }}u; i++) {
        let brings = dot(arrival(p, i).radiance, {{ luminance }});
        if brings > 0.0 && (left >= 0.0 || share == 0.0) {
            chosen = i;
            share = brings;
        }
        left -= brings;
    }
    let found = arrival(p, chosen);
    if !visible_between(p, found.direction, found.distance * (1.0 - 1e-5), seed) { return vec3f(0.0); }
    return found.radiance * (total / share);
}
{% endif %}

{% if emitters %}
// A glowing triangle or half an area light: radiance is that of its factor; id leads to its texture, 0 is an area light.
fn emitter_of(choice: f32) -> Emitter {
    var low = 0u;
    var high = settings.emitters - 1u;
    while low < high {
        let middle = (low + high) / 2u;
        if load_emitters(middle).cumulative > choice { high = middle; } else { low = middle + 1u; }
    }
    return load_emitters(low);
}

// Density over the area of a surface of this radiance: emitters are chosen by radiance * area.
fn area_density(radiance: vec3f) -> f32 { return dot(radiance, {{ luminance }}) * settings.inverse_emission; }

{% if "emissive_texture" in slots or cut %}
// Radiance of a glowing triangle at a point; black where its material's alpha leaves nothing there for this ray.
fn shine_of(emitter: Emitter, at: vec2f, seed: u32) -> vec3f {
    let weights = select(at, at.yx, emitter.turned == 1u);
    let item = load_items((emitter.id - 1u) >> CLUSTER_BITS);
    let material = load_materials(load_instances(item.instance).material);
    {% if cut %}
    if material.alpha_mode != 0u && !bvh_kept(emitter.id, weights.x, weights.y, seed) { return vec3f(0.0); }
    {% endif %}
    let corners = load_triangles(item.first_triangle + ((emitter.id - 1u) & ((1u << CLUSTER_BITS) - 1u)));
    let uv = load_vertices(corners.a).uv;
    let uv1 = load_vertices(corners.b).uv - uv;
    let uv2 = load_vertices(corners.c).uv - uv;
    return material_emissive(material, uv + weights.x * uv1 + weights.y * uv2, -50.0);
}
{% endif %}

fn emitters_at(p: Vertex_, choice: f32, u: vec2f, seed: u32) -> vec3f {
    let emitter = emitter_of(choice);
    let at = sample_triangle(u);
    let to_light = emitter.corner + at.x * emitter.edge1 + at.y * emitter.edge2 - p.position;
    let square = dot(to_light, to_light);
    let distance = sqrt(square);
    let l = to_light / distance;
    let leaving = -dot(normalize(cross(emitter.edge1, emitter.edge2)), l);
    if leaving <= 0.0 || square <= 0.0 { return vec3f(0.0); }
    var shine = emitter.radiance;
    {% if "emissive_texture" in slots or cut %}
    if emitter.id != 0u { shine = shine_of(emitter, at, seed); }
    {% endif %}
    let reflected = reflection(p.surface, p.to_eye, l) * shine;
    if max(reflected.r, max(reflected.g, reflected.b)) <= 0.0 { return vec3f(0.0); }
    let density = area_density(emitter.radiance) * square / leaving;
    if !visible_between(p, l, distance * (1.0 - 1e-4), seed) { return vec3f(0.0); }
    return reflected / (density + bounce_density_of(p.surface, p.to_eye, l));
}
{% endif %}

{% if emissive %}
// What a surface met by a ray of density `sampled` sends back, weighted; 0 is a ray that nothing else could have made.
fn emission_met(hit: Hit, material: Material, direction: vec3f, sampled: f32) -> vec3f {
    let leaving = -dot(hit.geometric_normal, direction);
    if leaving <= 0.0 && material.double_sided == 0u { return vec3f(0.0); }
    let shine = material_emissive(material, hit.uv, hit.footprint);
    {% if emitters %}
    if sampled > 0.0 {
        let density = area_density(material.emissive) * hit.depth * hit.depth / abs(leaving);
        return shine * balance(sampled, density);
    }
    {% endif %}
    return shine;
}
{% endif %}

{% if area_lights %}
// The same of the area lights that lie nearer than `distance`: of all of them, since they hide nothing, not even each
// other. They are the last of the emitters.
fn hit_area_lights(origin: vec3f, direction: vec3f, distance: f32, sampled: f32) -> vec3f {
    var shine = vec3f(0.0);
    for (var i = settings.emitters - {{ area_lights }}u; i < settings.emitters; i++) {
        let emitter = load_emitters(i);
        let n = cross(emitter.edge1, emitter.edge2);
        let slope = dot(n, direction);
        if slope >= 0.0 { continue; }
        let offset = emitter.corner - origin;
        let t = dot(n, offset) / slope;
        if t <= 0.0 || t >= distance { continue; }
        let point = t * direction - offset;
        let b1 = dot(cross(point, emitter.edge2), n) / dot(n, n);
        let b2 = dot(cross(emitter.edge1, point), n) / dot(n, n);
        if b1 < 0.0 || b2 < 0.0 || b1 + b2 > 1.0 { continue; }
        let density = area_density(emitter.radiance) * t * t * length(n) / -slope;
        shine += emitter.radiance * balance(sampled, density);
    }
    return shine;
}
{% endif %}

{% if sky %}
// Surroundings, by Walker's alias table over the texels of the map (1977): a texel is chosen by its light, a direction in it
// evenly by solid angle. table: probability of keeping, alias, luminance.
fn sky_cell_density(d: vec3f) -> f32 {
    let size = vec2f(textureDimensions(sky_table));
    let uv = environment_uv(d);
    let cell = vec2i(vec2f(fract(uv.x), min(uv.y, 0.9999999)) * size);
    return textureLoad(sky_table, cell, 0).z * settings.inverse_sky;
}

// choice: which texel, and whether it or its alias: apart, since one number has too few bits for both on a large map.
struct SkySample { direction: vec3f, density: f32 }

fn sample_sky(choice: vec2f, u: vec2f) -> SkySample {
    let size = textureDimensions(sky_table);
    let count = size.x * size.y;
    var cell = min(u32(choice.x * f32(count)), count - 1u);
    let entry = textureLoad(sky_table, vec2u(cell % size.x, cell / size.x), 0);
    if choice.y >= entry.x { cell = u32(entry.y); }
    let at = vec2u(cell % size.x, cell / size.x);
    let azimuth = ((f32(at.x) + u.x) / f32(size.x) - 0.5 - environment.turn) * {{ 2 * pi }};
    let height = mix(cos(f32(at.y) / f32(size.y) * {{ pi }}), cos(f32(at.y + 1u) / f32(size.y) * {{ pi }}), u.y);
    let across = sqrt(max(1.0 - height * height, 0.0));
    // The density is that of the texel chosen: led back from the direction, rounding might find the one beside it.
    let density = textureLoad(sky_table, at, 0).z * settings.inverse_sky;
    return SkySample(vec3f(across * sin(azimuth), height, -across * cos(azimuth)), density);
}

fn sky_at(p: Vertex_, choice: vec2f, u: vec2f, seed: u32) -> vec3f {
    let found = sample_sky(choice, u);
    let l = found.direction;
    let reflected = reflection(p.surface, p.to_eye, l) * environment_radiance(l);
    if found.density <= 0.0 || max(reflected.r, max(reflected.g, reflected.b)) <= 0.0 { return vec3f(0.0); }
    if !visible_between(p, l, FAR, seed) { return vec3f(0.0); }
    return reflected / (found.density + bounce_density_of(p.surface, p.to_eye, l));
}
{% endif %}

{% if particles %}
// One of the particle lights, chosen by intensity through an alias table (Walker 1977): by a number below their count, and by
// whether it or its alias. No reflected ray meets a point, so that nothing is weighed against it.
fn particles_at(p: Vertex_, choice: vec2f, seed: u32) -> vec3f {
    var chosen = min(u32(choice.x * f32(settings.particles)), settings.particles - 1u);
    let first = load_particles(chosen);
    if choice.y >= first.keep { chosen = first.instead; }
    let particle = load_particles(chosen);
    let to_light = particle.position - p.position;
    let square = dot(to_light, to_light);
    if square <= 0.0 { return vec3f(0.0); }
    let distance = sqrt(square);
    let l = to_light / distance;
    let reflected = reflection(p.surface, p.to_eye, l) * particle.intensity / square;
    if max(reflected.r, max(reflected.g, reflected.b)) <= 0.0 { return vec3f(0.0); }
    if !visible_between(p, l, distance * (1.0 - 1e-5), seed) { return vec3f(0.0); }
    return reflected / (dot(particle.intensity, {{ luminance }}) * settings.inverse_particles);
}
{% endif %}

fn sky_weight(direction: vec3f, sampled: f32) -> f32 {
    {% if sky %}
    return balance(sampled, sky_cell_density(direction));
    {% else %}
    return 1.0;
    {% endif %}
}

fn light_at(p: Vertex_, random: ptr<function, Sampler>, seed: u32) -> vec3f {
    var radiance = vec3f(0.0);
    {% if lamps or emitters or sky %}
    let choices = next_2d(random);
    {% endif %}
    {% if lamps %}
    radiance += lamps_at(p, choices.x, seed ^ 0x68bc21ebu);
    {% endif %}
    {% if emitters %}
    radiance += emitters_at(p, choices.y, next_2d(random), seed ^ 0x02e5be93u);
    {% endif %}
    {% if sky %}
    let where_ = next_2d(random);
    radiance += sky_at(p, next_2d(random), where_, seed ^ 0x967a889bu);
    {% endif %}
    {% if particles %}
    radiance += particles_at(p, next_2d(random), seed ^ 0x5d1c3a27u);
    {% endif %}
    return radiance;
}
