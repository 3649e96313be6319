{# Macros of a propagation step (CLPV 3.3), for templates that have the numbers of constants.py's `propagation_values`. #}
{% set axes = {"x": "w", "y": "y", "z": "z"} %}
{% macro within(x) %}{% if clamped %}max(0.0, {{ x }}){% else %}{{ x }}{% endif %}{% endmacro %}
{# Flux that cell `key` receives from the neighbour with emission e when light travels along `sign` `axis`: added to
   total_KEY and, times the lobes' directions, to vector_KEY. passing(key, axis, upper, travel): text of a factor, with
   its `*`, of what comes through the face at the upper or lower end of `axis` to light along the axis `travel`.
   across(key, axis, upper, travel), if given: text of the share of light along `travel` that surfaces across it block at the
   face. What they block goes to back_up_KEY or back_down_KEY, by `sign`; and all light that meets a face at a slant is added to
   slanted_up_KEY or slanted_down_KEY, by the face's end: surfaces across the face's axis block one share of it. #}
{% macro receive(key, axis, sign, passing, across=none) %}
    {% set way = "up" if sign == "1.0" else "down" %}
    {
        let along = {{ sign }} * e.{{ axes[axis] }};
        let far = {{ outside_far }} * e.x + {{ within(far0 ~ " * e.x + " ~ far_d ~ " * along") }};
        let far_passed = {{ passing(key, axis, sign == "1.0", axis) }}far;
        let base = {{ side0 }} * e.x + {{ side_d }} * along;
        let outside = {{ outside_side }} * e.x;
        var sides = 0.0;
        {% if across %}
        var back = far - far_passed;
        {% endif %}
        {% for other in "xyz" if other != axis %}
        {
            let aside = {{ side_s }} * e.{{ axes[other] }};
            let up = outside + {{ within("base + aside") }};
            let down = outside + {{ within("base - aside") }};
            let up_passed = {{ passing(key, other, true, axis) }}up;
            let down_passed = {{ passing(key, other, false, axis) }}down;
            sides += up_passed + down_passed;
            vector_{{ key }}.{{ other }} += {{ side_across }} * (up_passed - down_passed);
            {% if across %}
            slanted_up_{{ key }}.{{ other }} += up;
            slanted_down_{{ key }}.{{ other }} += down;
            back += {{ across(key, other, true, axis) }} * up + {{ across(key, other, false, axis) }} * down;
            {% endif %}
        }
        {% endfor %}
        total_{{ key }} += far_passed + sides;
        vector_{{ key }}.{{ axis }} += {{ sign }} * (far_passed{% if side_along %} + {{ side_along }} * sides{% endif %});
        {% if across %}
        back_{{ way }}_{{ key }}.{{ axis }} = back;
        {% endif %}
    }
{% endmacro %}
