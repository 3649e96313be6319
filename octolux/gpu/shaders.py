"""WGSL from templates: files of the package composed with Jinja2, and errors led back to the line they came from.

A template says `{{ use("shaders/sh.wgsl") }}` to include another file once, and may use Jinja2's loops to unroll.
`{% set step = macros("FILE") %}` lends it another file's macros, as `{{ step.NAME(...) }}`.
Names that were not passed in are errors. Paths start at the package's folder, so every name is full. A macro that is
used inside a line must itself stand on one line, since each line carries a mark of its origin as a comment.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from functools import lru_cache
from pathlib import Path
from typing import Any

import jinja2
import wgpu

from ..scene.errors import OctoluxError

PACKAGE = Path(__file__).parent.parent
# The last line of a used file also carries the mark of the line that uses it: the first one counts.
_MARK = re.compile(r"[ \t]*//@(\d+):(\d+)(?:[ \t]*//@\d+:\d+)*[ \t]*$")
# The compiler names the place after the module's label, or `wgsl` while it parses. Of a fault inside a function it
# names the function's first line, and underlines the expression.
_PLACES = (re.compile(r"^ *(\d+) │.*\n[ │]*\^+ naga::ir::Expression", re.M), re.compile(r"┌─ .*:(\d+):\d+"))
_JINJA = jinja2.Environment(undefined=jinja2.StrictUndefined, trim_blocks=False)
_OPEN, _CLOSE = ("{%", "{{", "{#"), ("%}", "}}", "#}")


class ShaderError(OctoluxError):
    """WGSL that did not compile, with the file and line it stands in."""


class Source:
    """Composed WGSL and where each of its lines came from."""

    def __init__(self, text: str, origins: list[tuple[str, int]]):
        self.text, self.origins = text, origins

    def explain(self, message: str) -> str:
        """The compiler's message with the original file and line in front of it."""
        match = next(filter(None, (place.search(message) for place in _PLACES)), None)
        if not match or not 0 < int(match[1]) <= len(self.origins):
            return message
        file, line = self.origins[int(match[1]) - 1]
        return f"octolux/{file}:{line}: in '{self.text.splitlines()[int(match[1]) - 1].strip()}'\n{message}"


class _Composer:
    """Renders one module: remembers which files it has used, and their names for the line marks."""

    def __init__(self, root: Path, values: dict[str, Any]):
        self.root, self.values = root, values
        self.files: list[str] = []

    def use(self, name: str) -> str:
        """The text of the file `name`, or nothing when it is already part of this module."""
        if name in self.files:
            return ""
        self.files.append(name)
        return self._made(name, lambda template: template.render(self.values, use=self.use, macros=self.macros))

    def macros(self, name: str) -> Any:
        """The macros of the file `name`, which has nothing else, as attributes."""
        self.files.append(name)
        return self._made(name, lambda template: template.make_module(self.values))

    def _made(self, name: str, make: Callable[[jinja2.Template], Any]) -> Any:
        """What `make` makes of the file that was named last."""
        try:
            text = (self.root / name).read_text(encoding="utf-8")
            return make(_template(_mark_lines(text, len(self.files) - 1)))
        except FileNotFoundError as error:
            raise ShaderError(f"octolux/{name}: no such shader file") from error
        except jinja2.TemplateError as error:
            raise ShaderError(f"octolux/{name}: {error}") from error


@lru_cache(maxsize=512)
def _template(text: str) -> jinja2.Template:
    """Compiled once: a device's passes are made anew with other values, and several use the same files."""
    return _JINJA.from_string(text)


def _mark_lines(text: str, file: int) -> str:
    """Append `//@file:line` to each line that does not end inside a Jinja2 tag."""
    lines, depth = [], 0
    for number, line in enumerate(text.splitlines(), 1):
        depth += sum(line.count(t) for t in _OPEN) - sum(line.count(t) for t in _CLOSE)
        lines.append(line if depth else f"{line} //@{file}:{number}")
    return "\n".join(lines) + "\n"


def compose(name: str, header: Iterable[str] = (), root: Path = PACKAGE, **values: Any) -> Source:
    """The WGSL of file `name`, with everything it uses, below the lines of `header`.

    Raises ShaderError for a missing file, a bad template or a name that is not in `values`.
    """
    composer = _Composer(root, values)
    body = composer.use(name)
    lines = [line for block in header for line in block.splitlines()]
    origins = [("(declarations)", i + 1) for i in range(len(lines))]
    for line in body.splitlines():
        mark = _MARK.search(line)
        where = (composer.files[int(mark[1])], int(mark[2])) if mark else (origins[-1] if origins else (name, 1))
        stripped = _MARK.sub("", line)
        lines.append(stripped)
        origins.append(where)
    return Source("\n".join(lines) + "\n", origins)


def compile_module(device: Any, label: str, source: Source) -> Any:
    """A shader module. Raises ShaderError that names the original file and line."""
    try:
        return device.create_shader_module(label=label, code=source.text)
    except wgpu.GPUError as error:
        raise ShaderError(source.explain(str(error))) from error
