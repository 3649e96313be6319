"""The command `octolux simulate`: a script of the laboratory, run and written."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.table import Table

from . import console
from .output.atomic import replacing
from .scene.errors import OctoluxError
from .viewer.simulate import HOST, PORT

if TYPE_CHECKING:
    from .simulator.laboratory import Simulation

_Script = Annotated[
    Path | None,
    typer.Argument(metavar="SCRIPT", help="A .toml or .json file of settings and actions; docs/simulate.md."),
]
_Out = Annotated[
    Path,
    typer.Option(
        metavar="DIR", help="Folder for state.npz, errors.csv, errors.png, slices.png, and what the script names."
    ),
]


_Serve = Annotated[
    bool, typer.Option("--serve", help="Open the laboratory in the browser instead, with what SCRIPT makes, if given.")
]
_Host = Annotated[str, typer.Option(metavar="ADDRESS", help="With --serve: the address to listen at.")]
_Port = Annotated[int, typer.Option(min=0, max=65535, help="With --serve: the port; 0 takes any that is free.")]
_Flatland = Annotated[
    bool, typer.Option("--flatland", help="Compare propagation in the plane instead: flatland.png, flatland.csv.")
]
_Bands = Annotated[str, typer.Option(metavar="B,...", help="With --flatland: bands of circular harmonics.")]


def simulate(
    script: _Script = None,
    out: _Out = Path("simulation"),
    serve: _Serve = False,
    host: _Host = HOST,
    port: _Port = PORT,
    flatland: _Flatland = False,
    bands: _Bands = "2,4,16",
) -> None:
    """Run SCRIPT in the laboratory of light propagation volumes.

    Float64 on the CPU, one colour channel; docs/simulate.md lists what a script may hold.
    """
    if flatland:
        if script is not None or serve:
            raise OctoluxError("--flatland takes no script and has no page. Leave the others out.")
        _flatland(bands, out)
    elif serve:
        _serve(script, host, port)
    elif script is None:
        raise OctoluxError("There is no script to run. Give one, or --serve, or --flatland.")
    else:
        _run(script, out)


def _run(script: Path, out: Path) -> None:
    """Run the script, and write what it made and what is always written."""
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


def _serve(script: Path | None, host: str, port: int) -> None:
    """The page, until it is stopped. A script is tried first, so that its mistakes are told here."""
    from .simulator.laboratory import Simulation
    from .simulator.laboratory.script import Script
    from .viewer.simulate.server import serve

    def begun() -> Simulation:
        if script is None:
            return Simulation(16)
        read = Script(script)
        read.run()
        return read.simulation

    begun()
    serve(begun, host, port, lambda address: console.out.print(f"the laboratory is at {address} (Ctrl+C ends it)"))


def _flatland(bands: str, out: Path) -> None:
    """The figure and the table of propagation in the plane (Kaplanyan & Dachsbacher 2010, section 5)."""
    from .compare.report import check_folder
    from .simulator.flatland.results import flatland_files

    try:
        numbers = [int(part) for part in bands.split(",")]
    except ValueError as error:
        raise OctoluxError(f"--bands takes whole numbers such as 2,4,16, not '{bands}'.") from error
    check_folder(out)
    files, rows = flatland_files(numbers)
    write(files, out)
    table = Table(box=None)
    for name in ("setting", "basis", "scheme"):
        table.add_column(name, no_wrap=True)
    for name in ("relative\nRMSE", "flux\nratio", "degrees\noff"):
        table.add_column(name, justify="right", no_wrap=True)
    for row in rows:
        figures = (f"{row[name]:.3g}" for name in ("relative_rmse", "flux_ratio", "direction_error"))
        table.add_row(row["setting"], row["basis"], row["scheme"], *figures)
    console.out.print(table)
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
