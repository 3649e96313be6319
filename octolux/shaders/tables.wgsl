{# A table in a texture between its nodes: `at` in texels, whose middles are whole numbers; held at its rim. Two tables are
   float32, which not every device filters. -#}
{% macro between_nodes(name, table) %}
fn {{ name }}(at: vec2f) -> vec4f {
    let last = vec2i(textureDimensions({{ table }})) - 1;
    let held = clamp(at, vec2f(0.0), vec2f(last));
    let low = vec2i(held);
    let high = min(low + 1, last);
    let part = held - vec2f(low);
    let upper = mix(textureLoad({{ table }}, low, 0), textureLoad({{ table }}, vec2i(high.x, low.y), 0), part.x);
    let lower = mix(textureLoad({{ table }}, vec2i(low.x, high.y), 0), textureLoad({{ table }}, high, 0), part.x);
    return mix(upper, lower, part.y);
}
{% endmacro %}
