{# Macros of a propagation step (CLPV 3.3), for templates that have the numbers of constants.py's `propagation_values`. #}
{% set axes = {"x": "w", "y": "y", "z": "z"} %}
{% macro within(x) %}{% if clamped %}max(0.0, {{ x }}){% else %}{{ x }}{% endif %}{% endmacro %}
{# Flux that cell `key` receives from the neighbour with emission e when light travels along `sign` `axis`: added to
   total_KEY and, times the lobes' directions, to vector_KEY. passing(key, axis, upper, travel): text of a factor, with
   its `*`, of what comes through the face at the upper or lower end of `axis` to light along the axis `travel`. #}
{% macro receive(key, axis, sign, passing) %}
    {
        let along = {{ sign }} * e.{{ axes[axis] }};
        let far = {{ passing(key, axis, sign == "1.0", axis) }}({{ outside_far }} * e.x + {{ within(far0 ~ " * e.x + " ~ far_d ~ " * along") }});
        let base = {{ side0 }} * e.x + {{ side_d }} * along;
        let outside = {{ outside_side }} * e.x;
        var sides = 0.0;
        {% for other in "xyz" if other != axis %}
        {
            let across = {{ side_s }} * e.{{ axes[other] }};
            let up = {{ passing(key, other, true, axis) }}(outside + {{ within("base + across") }});
            let down = {{ passing(key, other, false, axis) }}(outside + {{ within("base - across") }});
            sides += up + down;
            vector_{{ key }}.{{ other }} += {{ side_across }} * (up - down);
        }
        {% endfor %}
        total_{{ key }} += far + sides;
        vector_{{ key }}.{{ axis }} += {{ sign }} * (far{% if side_along %} + {{ side_along }} * sides{% endif %});
    }
{% endmacro %}
