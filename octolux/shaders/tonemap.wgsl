// Tone maps and the sRGB transfer function; references and sources: simulator/tonemap.py.

fn clipped(color: vec3f) -> vec3f { return saturate(color); }

fn agx(color: vec3f) -> vec3f {
    let inset = max({{ agx_inset }} * color, vec3f(1e-10));
    let x = saturate((log2(inset) - {{ agx_ev[0] }}) / {{ agx_ev[1] - agx_ev[0] }});
    var curve = vec3f(0.0);
    {% for c in agx_curve|reverse %}
    curve = curve * x + {{ c }};
    {% endfor %}
    return pow(saturate({{ agx_outset }} * curve), vec3f({{ agx_power }}));
}

fn aces(color: vec3f) -> vec3f {
    let x = {{ aces_input }} * color;
    let a = x * (x + {{ aces_numerator[0] }}) + {{ aces_numerator[1] }};
    let b = x * ({{ aces_denominator[0] }} * x + {{ aces_denominator[1] }}) + {{ aces_denominator[2] }};
    return saturate({{ aces_output }} * (a / b));
}

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
