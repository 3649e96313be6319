"""The command `octolux simulate`: a script of the laboratory, run and written."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.table import Table

from . import console
from .output.atomic import replacing

if TYPE_CHECKING:
    from .simulator.laboratory import Simulation

_Script = Annotated[
    Path, typer.Argument(metavar="SCRIPT", help="A .toml or .json file of settings and actions; docs/simulate.md.")
]
_Out = Annotated[
    Path,
    typer.Option(
        metavar="DIR", help="Folder for state.npz, errors.csv, errors.png, slices.png, and what the script names."
    ),
]


def simulate(script: _Script, out: _Out = Path("simulation")) -> None:
    """Run SCRIPT in the laboratory of light propagation volumes.

    Float64 on the CPU, one colour channel; docs/simulate.md lists what a script may hold.
    """
    from .compare.report import check_folder
    from .simulator.laboratory.results import final_files
    from .simulator.laboratory.script import Script

    read = Script(script)
    check_folder(out)
    files = read.run(lambda text: console.notes.print(text, markup=False))
    files |= final_files(read.simulation)
    write(files, out)
    _print(read.simulation)
    console.out.print(f"wrote {', '.join(files)} to {out}", markup=False, soft_wrap=True)


def write(files: dict[str, bytes], folder: Path) -> None:
    """Write `files` (contents by name) into `folder`, which is made. Raises OctoluxError."""
    folder.mkdir(exist_ok=True)
    for name, contents in files.items():
        with replacing(folder / name) as temporary:
            temporary.write_bytes(contents)


def _print(simulation: Simulation) -> None:
    """The measures as a table, a few rows of many."""
    rows = simulation.state.measures
    columns = {
        "iteration": "step", "e_abs": "6.2\ne_abs", "e_rel": "6.2\ne_rel", "corrected_e_abs": "7\ne_abs",
        "corrected_e_rel": "7\ne_rel", "merged_rel": "from\nuniform", "analytic_rel": "from\nexact",
        "step_flux": "step's\nflux", "sum_flux": "sum's\nflux",
    }  # fmt: skip
    shown = [name for name in columns if any(name in row for row in rows)]
    if not shown:
        return
    table = Table(box=None)
    for name in shown:
        table.add_column(columns[name], justify="right", no_wrap=True)
    stride = 1 + len(rows) // 16
    for row in [*rows[:-1:stride], rows[-1]]:
        table.add_row(*(f"{row[name]:.3g}" if name in row else "" for name in shown))
    console.out.print(table)
