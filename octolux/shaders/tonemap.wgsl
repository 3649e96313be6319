// Khronos PBR neutral tone map (2024) and the sRGB transfer function (IEC 61966-2-1).

fn neutral_tone_map(radiance: vec3f) -> vec3f {
    let x = min(radiance.r, min(radiance.g, radiance.b));
    let offset = select({{ f90_offset }}, x - 6.25 * x * x, x < {{ 2 * f90_offset }});
    let color = radiance - offset;
    let peak = max(color.r, max(color.g, color.b));
    let high = max(peak, {{ start_compression }});
    let room = {{ 1 - start_compression }};
    let new_peak = 1.0 - room * room / (high + room - {{ start_compression }});
    let white = 1.0 - 1.0 / ({{ desaturation }} * (high - new_peak) + 1.0);
    let compressed = mix(color * (new_peak / high), vec3f(new_peak), white);
    return select(color, compressed, peak >= {{ start_compression }});
}

fn srgb_encode(linear: vec3f) -> vec3f {
    let c = saturate(linear);
    return select(1.055 * pow(c, vec3f(1.0 / 2.4)) - 0.055, 12.92 * c, c <= vec3f(0.0031308));
}
