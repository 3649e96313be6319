"""Composed WGSL: includes, templates, and errors that name the file and line they come from."""

from __future__ import annotations

import re

import pytest

from octolux.gpu.shaders import ShaderError, compile_module, compose

LIBRARY = "fn twice(x: f32) -> f32 { return 2.0 * x; }\n"


@pytest.fixture
def write(tmp_path):
    """Write files below `tmp_path` and return it."""

    def write_files(**files: str):
        for name, text in files.items():
            (tmp_path / f"{name}.wgsl").write_text(text)
        return tmp_path

    return write_files


def test_a_file_is_used_once(write):
    root = write(
        lib=LIBRARY, middle='{{ use("lib.wgsl") }}\nconst M = 1;\n',
        main='{{ use("lib.wgsl") }}\n{{ use("middle.wgsl") }}\n{{ use("lib.wgsl") }}\nconst N = 2;\n',
    )  # fmt: skip
    text = compose("main.wgsl", root=root).text
    assert text.count("fn twice") == 1
    assert text.index("fn twice") < text.index("const M") < text.index("const N")
    assert "//@" not in text


def test_files_that_use_each_other_end(write):
    root = write(a='{{ use("b.wgsl") }}\nconst A = 1;\n', b='{{ use("a.wgsl") }}\nconst B = 1;\n')
    assert compose("a.wgsl", root=root).text.count("const A") == 1


def test_values_and_loops(write):
    root = write(main="{% for i in range(count) %}\nconst V{{ i }} = {{ i * 2 }};\n{% endfor %}\n")
    text = compose("main.wgsl", root=root, count=3).text
    assert re.findall(r"const V\d = \d;", text) == ["const V0 = 0;", "const V1 = 2;", "const V2 = 4;"]


def test_macros_of_another_file(write):
    """They see the values, take macros as arguments, and their lines are led back to their own file."""
    root = write(
        lib="{% macro declare(name, made) %}\nconst {{ name }} = {{ made(2) }};\n{% endmacro %}\n",
        main='{% set lib = macros("lib.wgsl") %}\n'
        "{% macro scaled(x) %}{{ x * count }}{% endmacro %}\n{{ lib.declare('A', scaled) }}\n",
    )
    source = compose("main.wgsl", root=root, count=3)
    assert "const A = 6;" in source.text and "//@" not in source.text
    line = source.text.splitlines().index("const A = 6;")
    assert source.origins[line] == ("lib.wgsl", 2)
    with pytest.raises(ShaderError, match=r"none\.wgsl: no such shader file"):
        compose("a.wgsl", root=write(a='{{ macros("none.wgsl") }}\n'))


def test_undefined_name(write):
    root = write(lib="const X = {{ radius }};\n", main='{{ use("lib.wgsl") }}\n')
    with pytest.raises(ShaderError, match=r"lib\.wgsl.*radius.*undefined"):
        compose("main.wgsl", root=root)


def test_undefined_name_in_a_condition(write):
    root = write(main="{% if shadows %}\nconst X = 1;\n{% endif %}\n")
    with pytest.raises(ShaderError, match="shadows"):
        compose("main.wgsl", root=root)


@pytest.mark.parametrize("text", ["{% if x %}\n", "{{ x", "{% endfor %}", "{{ 1 + }}"])
def test_bad_template(write, text):
    with pytest.raises(ShaderError, match=r"main\.wgsl"):
        compose("main.wgsl", root=write(main=text), x=1)


@pytest.mark.parametrize("text", ['{{ use("absent.wgsl") }}', '{% if true %}\n{{ use("absent.wgsl") }}\n{% endif %}'])
def test_missing_file(write, text):
    with pytest.raises(ShaderError, match=r"absent\.wgsl: no such shader file"):
        compose("main.wgsl", root=write(main=text))
    with pytest.raises(ShaderError, match="no such shader file"):
        compose("nowhere.wgsl", root=write(main=""))


MAIN = '{{ use("lib.wgsl") }}\n@compute @workgroup_size(1)\nfn main() {}\n'
# A library with a mistake, and the line it stands in.
MISTAKES = {
    "first line": ("fn f() -> f32 { return 1u; }\nconst A = 1;\n", 1),
    "after others": ("const A = 1;\n\n// note\nfn f() -> f32 { return 1u; }\n", 4),
    "after an include": ('{{ use("other.wgsl") }}\n\nfn f() -> f32 { return 1u; }\n', 3),
    "in a loop": ("{% for i in range(4) %}\n\nfn f{{ i }}() -> f32 { return 1u; }\n{% endfor %}\n", 3),
    "after a loop": ("{% for i in range(4) %}\nconst A{{ i }} = 1;\n{% endfor %}\nfn f() -> f32 { return 1u; }\n", 4),
    "in a condition": ("{% if true %}\nfn f() -> f32 { return 1u; }\n{% else %}\nconst A = 1;\n{% endif %}\n", 2),
    "after a comment": ("{# one\ntwo\nthree #}\nfn f() -> f32 { return 1u; }\n", 4),
    "after a long tag": ("{% set x = [\n  1,\n  2,\n] %}\nfn f() -> f32 { return {{ x[0] }}u; }\n", 5),
    "in a macro": ("{% macro m() %}\n    return 1u;\n{% endmacro %}\nfn f() -> f32 {\n{{ m() }}\n}\n", 2),
    "several lines": ("fn f() -> f32 {\n    let a = 1.0;\n    return\n        1u;\n}\n", (3, 4)),
    "a syntax error": ("const A = 1;\nfn f() -> f32 { return 1.0 }\n", 2),
}  # fmt: skip


@pytest.mark.parametrize("place", MISTAKES)
def test_errors_name_file_and_line(device, write, place):
    text, lines = MISTAKES[place]
    root = write(lib=text, other=LIBRARY, main=MAIN)
    with pytest.raises(ShaderError) as caught:
        compile_module(device.wgpu, "test", compose("main.wgsl", ["struct S { a: f32 }"], root=root))
    named = re.match(r"octolux/lib\.wgsl:(\d+): in '(.+)'", str(caught.value))
    assert named, str(caught.value)
    assert int(named[1]) in (lines if isinstance(lines, tuple) else (lines,))
    assert named[2].strip() in text.replace("{{ i }}", "0").replace("{{ x[0] }}", "1")


def test_errors_of_the_main_file_and_of_declarations(device, write):
    root = write(lib=LIBRARY, main=MAIN + "fn g() -> u32 { return 1.5; }\n")
    with pytest.raises(ShaderError, match=r"^octolux/main\.wgsl:4: "):
        compile_module(device.wgpu, "test", compose("main.wgsl", root=root))
    with pytest.raises(ShaderError, match=r"declarations\):2: "):
        compile_module(device.wgpu, "test", compose("lib.wgsl", ["const A = 1;", "const B: f32 = 1u;"], root=root))


def test_messages_without_a_place_stay_as_they_are(write):
    source = compose("lib.wgsl", root=write(lib=LIBRARY))
    assert source.explain("out of luck") == "out of luck"
    assert source.explain("┌─ test:99:1 beyond the end") == "┌─ test:99:1 beyond the end"
