// Fast approximate anti-aliasing (Lottes 2009, "FXAA" whitepaper; quality version 3.11): finds the ends of the edge that a
// pixel lies on, and reads the picture across the edge by as much as the edge's slope says; single pixels are blurred a
// little. Works on the picture for display, since what is seen as an edge is a matter of signals.

fn luma_of(color: vec3f) -> f32 { return dot(color, vec3f(0.299, 0.587, 0.114)); }
fn luma_at(at: vec2f) -> f32 { return luma_of(textureSampleLevel(picture, picture_sampler, at, 0.0).rgb); }

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(picture);
    if any(id.xy >= size) { return; }
    let texel = 1.0 / vec2f(size);
    let at = (vec2f(id.xy) + 0.5) * texel;
    let color = textureLoad(picture, id.xy, 0);
    let m = luma_of(color.rgb);
    let n = luma_at(at - vec2f(0.0, texel.y));
    let s = luma_at(at + vec2f(0.0, texel.y));
    let w = luma_at(at - vec2f(texel.x, 0.0));
    let e = luma_at(at + vec2f(texel.x, 0.0));
    let brightest = max(m, max(max(n, s), max(w, e)));
    let range = brightest - min(m, min(min(n, s), min(w, e)));
    if range < max({{ threshold_min }}, brightest * {{ threshold }}) {
        textureStore(picture_out, id.xy, color);
        return;
    }
    let nw = luma_at(at - texel);
    let se = luma_at(at + texel);
    let ne = luma_at(at + vec2f(texel.x, -texel.y));
    let sw = luma_at(at + vec2f(-texel.x, texel.y));
    let bend_across = abs(nw - 2.0 * w + sw) + 2.0 * abs(n - 2.0 * m + s) + abs(ne - 2.0 * e + se);
    let bend_along = abs(nw - 2.0 * n + ne) + 2.0 * abs(w - 2.0 * m + e) + abs(sw - 2.0 * s + se);
    let horizontal = bend_across >= bend_along;

    // The side of the pixel on which the edge lies, and half a pixel towards it.
    let before = select(w, n, horizontal);
    let after = select(e, s, horizontal);
    let first = abs(before - m) >= abs(after - m);
    let other = select(after, before, first);
    let across = select(vec2f(texel.x, 0.0), vec2f(0.0, texel.y), horizontal) * select(1.0, -1.0, first);
    let along = select(vec2f(0.0, texel.y), vec2f(texel.x, 0.0), horizontal);
    let level = 0.5 * (m + other);
    let steepness = 0.25 * max(abs(before - m), abs(after - m));

    // Along the edge both ways until its brightness changes.
    var reach = vec2f(0.0);
    var change = vec2f(0.0);
    var going = vec2<bool>(true);
    {% for step in steps %}
    if any(going) {
        if going.x {
            reach.x += {{ step }};
            change.x = luma_at(at + 0.5 * across - reach.x * along) - level;
        }
        if going.y {
            reach.y += {{ step }};
            change.y = luma_at(at + 0.5 * across + reach.y * along) - level;
        }
        going = abs(change) < vec2f(steepness);
    }
    {% endfor %}
    let nearer_first = reach.x < reach.y;
    let nearest = select(reach.y, reach.x, nearer_first);
    let end = select(change.y, change.x, nearer_first);
    // Only the half of the edge towards which the pixel is on the wrong side is moved.
    let wrong_side = (end < 0.0) != (m - level < 0.0);
    let edge_shift = select(0.0, 0.5 - nearest / (reach.x + reach.y), wrong_side);

    let mean = (2.0 * (n + s + w + e) + nw + ne + sw + se) / 12.0;
    let contrast = saturate(abs(mean - m) / range);
    let smooth_contrast = contrast * contrast * (3.0 - 2.0 * contrast);
    let shift = max(edge_shift, smooth_contrast * smooth_contrast * {{ subpixel }});
    textureStore(picture_out, id.xy, textureSampleLevel(picture, picture_sampler, at + shift * across, 0.0));
}
