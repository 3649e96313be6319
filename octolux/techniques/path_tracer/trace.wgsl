// Path tracing (Kajiya 1986) with next-event estimation and multiple importance sampling (Veach 1997, balance heuristic).
// Each dispatch adds paths to the sums of a tile of pixels; the pictures' means are taken in resolve.wgsl.
{{ use("shaders/surface.wgsl") }}
{{ use("shaders/brdf.wgsl") }}
{{ use("shaders/environment.wgsl") }}
{{ use("shaders/sampler.wgsl") }}
{{ use("shaders/sample_directions.wgsl") }}
{{ use("raytracing/traverse.wgsl") }}
{{ use("shaders/lights.wgsl") }}
{{ use("techniques/path_tracer/surface_sampling.wgsl") }}
{{ use("techniques/path_tracer/lights.wgsl") }}

const FAR = 3.0e38;

// Where a path is: the surface, and which way it is seen.
struct Vertex_ { position: vec3f, to_eye: vec3f, surface: Surface }

// Rays begin this far off a surface, on the side they leave to: a few ulps of the coordinates (Wächter and Binder 2019, "A Fast
// and Robust Method for Avoiding Self-Intersection", say 2^-16 of them), scaled by the largest coordinate.
fn offset_origin(position: vec3f, geometric_normal: vec3f, direction: vec3f) -> vec3f {
    let largest = max(max(abs(position.x), abs(position.y)), max(abs(position.z), 1e-3));
    let side = select(-1.0, 1.0, dot(geometric_normal, direction) > 0.0);
    return position + geometric_normal * (side * largest * 1.5e-5);
}

// Not for unlit materials: paths end there.
fn surface_of(hit: Hit, material: Material, direction: vec3f) -> Surface {
    let facing = select(1.0, -1.0, dot(hit.geometric_normal, direction) > 0.0);
    let roughness_metallic = material_roughness_metallic(material, hit.uv, hit.footprint);
    let reflected = base_color(hit, material).rgb;
    {% if diffuse_only %}
    return Surface(facing * mapped_normal(hit, material), facing * hit.geometric_normal,
        reflected * (1.0 - roughness_metallic.y), 1.0, 0.0, 0.0);
    {% else %}
    return Surface(facing * mapped_normal(hit, material), facing * hit.geometric_normal, reflected,
        roughness_metallic.x, roughness_metallic.y, material.specular);
    {% endif %}
}

struct Sums { radiance: vec3f, coverage: f32, direct: vec3f, indirect: vec3f }

fn trace_path(pixel: vec2u, index: u32) -> Sums {
    var random = start_sampler(pixel, index, settings.seed);
    {% if centre %}
    let at = vec2f(pixel) + 0.5;
    {% else %}
    let at = vec2f(pixel) + next_2d(&random);
    {% endif %}
    let seen_ray = view_ray(views[0], at);
    // The camera's ray has unit length along its axis: nothing before the near plane is seen.
    var direction = normalize(seen_ray.direction);
    var origin = seen_ray.origin;
    var nearest = settings.near * length(seen_ray.direction);
    // How the ray moves from pixel to pixel. A path through the whole pixel averages textures by itself; one through the centre
    // sees them filtered, as other techniques do. What it meets later is not filtered.
    var to_right = Ray(vec3f(0.0), vec3f(0.0));
    var down = Ray(vec3f(0.0), vec3f(0.0));
    {% if centre %}
    let stretch = 1.0 / length(seen_ray.direction);
    to_right = Ray(views[0].origin_dx, views[0].direction_dx * stretch);
    down = Ray(views[0].origin_dy, views[0].direction_dy * stretch);
    {% endif %}

    var emitted = vec3f(0.0);
    var direct = vec3f(0.0);
    var indirect = vec3f(0.0);
    var coverage = 0.0;
    var throughput = vec3f(1.0);
    var bounce_density = 0.0;
    for (var depth = 0u; depth <= {{ bounces + 1 }}u; depth++) {
        let seed = combine_hashes(random.seed, index * 257u + depth);
        let found = closest_hit(origin, direction, nearest, FAR, seed, depth == 0u);
        {% if area_lights %}
        // Area lights are no geometry: they are met only by reflected rays. One that lies on a surface lies before it.
        if depth > 0u {
            let end = select(FAR, found.t * (1.0 + 1e-4), found.id != 0u);
            let lamp = hit_area_lights(origin, direction, end, bounce_density);
            if depth == 1u { direct += throughput * lamp; } else { indirect += throughput * lamp; }
        }
        {% endif %}
        if found.id == 0u {
            {% if transparent %}
            if depth == 0u { break; }
            {% endif %}
            var sky = environment_radiance(direction);
            if depth > 0u {
                sky *= sky_weight(direction, bounce_density);
            }
            if depth == 0u { emitted += sky; } else if depth == 1u { direct += throughput * sky; } else { indirect += throughput * sky; }
            break;
        }
        let hit = hit_triangle(found.id, Ray(origin, direction), to_right, down);
        let material = load_materials(hit.material);
        if depth == 0u { coverage = 1.0; }
        {% if unlit %}
        if material.unlit == 1u {
            if depth == 0u { emitted += base_color(hit, material).rgb / settings.exposure; }
            break;
        }
        {% endif %}
        {% if emissive %}
        let glow = emission_met(hit, material, direction, select(bounce_density, 0.0, depth == 0u));
        if depth == 0u { emitted += glow; } else if depth == 1u { direct += throughput * glow; } else { indirect += throughput * glow; }
        {% endif %}
        if depth == {{ bounces + 1 }}u { break; }
        let here = Vertex_(hit.position, -direction, surface_of(hit, material, direction));
        let lit = throughput * light_at(here, &random, seed);
        if depth == 0u { direct += lit; } else { indirect += lit; }

        let choice = next_2d(&random).x;
        let bounce = sample_bounce(here.surface, here.to_eye, choice, next_2d(&random));
        throughput *= bounce.weight;
        let strength = max(throughput.r, max(throughput.g, throughput.b));
        if bounce.density <= 0.0 || strength <= 0.0 { break; }
        if depth >= 3u {
            let survival = min(strength, 0.95);
            if next_2d(&random).x >= survival { break; }
            throughput /= survival;
        }
        bounce_density = bounce.density;
        direction = bounce.direction;
        origin = offset_origin(here.position, here.surface.geometric_normal, direction);
        nearest = 0.0;
        {% if centre %}
        to_right = Ray(vec3f(0.0), vec3f(0.0));
        down = to_right;
        {% endif %}
    }
    {% if paths == "all" %}
    let shown = emitted + direct + indirect;
    {% elif paths == "direct" %}
    let shown = emitted + direct;
    {% else %}
    let shown = indirect;
    {% endif %}
    return Sums(shown, coverage, direct, indirect);
}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let pixel = id.xy + settings.tile_origin;
    if any(id.xy >= settings.tile_size) { return; }
    // The sums of a picture begin anew.
    var radiance = vec4f(0.0);
    var direct = vec4f(0.0);
    var indirect = vec4f(0.0);
    if settings.fresh == 0u {
        radiance = textureLoad(radiance_sum_in, pixel, 0);
        direct = textureLoad(direct_sum_in, pixel, 0);
        indirect = textureLoad(indirect_sum_in, pixel, 0);
    }
    for (var i = 0u; i < settings.samples; i++) {
        let path = trace_path(pixel, settings.first_sample + i);
        let luminance = dot(path.radiance, {{ luminance }});
        // A path that is no number would spoil the pixel for good.
        if luminance == luminance && luminance < FAR {
            radiance += vec4f(path.radiance, path.coverage);
            direct += vec4f(path.direct, luminance * luminance);
            indirect += vec4f(path.indirect, 0.0);
        }
    }
    textureStore(radiance_sum_out, pixel, radiance);
    textureStore(direct_sum_out, pixel, direct);
    textureStore(indirect_sum_out, pixel, indirect);
}
