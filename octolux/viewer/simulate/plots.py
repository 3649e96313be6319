"""What is measured after each accumulation, against its iteration: one plot for each panel of the error picture."""

from __future__ import annotations

from itertools import cycle

from bokeh.models import ColumnDataSource, HoverTool, Range1d
from bokeh.palettes import Category10
from bokeh.plotting import figure

from octolux.simulator.laboratory.pictures import PANELS

from .grids import TOOLS
from .laboratory import Laboratory

_CENTRE = next(title for title in PANELS if title.startswith("centre"))


def plots(laboratory: Laboratory) -> list[figure]:
    """A plot for each of `PANELS`, kept up to date by `laboratory`."""
    sources: dict[str, ColumnDataSource] = {}
    made = [_plot(title, columns, sources) for title, columns in PANELS.items()]

    def show() -> None:
        rows = laboratory.simulation.state.measures
        for column, source in sources.items():
            found = [(row["iteration"], row[column]) for row in rows if column in row]
            data = {"iteration": [i for i, _ in found], "value": [value for _, value in found]}
            if data != source.data:  # what is set is painted again, also where it is the same
                source.data = data
        for plot, (title, columns) in zip(made, PANELS.items(), strict=True):
            measured = any(sources[column].data["value"] for column in columns)
            plot.title.text = title if measured else f"{title}: not measured"
        # Of light that keeps its place, the axis would show rounding.
        made[list(PANELS).index(_CENTRE)].y_range.update(start=-0.5, end=laboratory.simulation.state.n - 0.5)

    laboratory.listeners.append(show)
    return made


def _plot(title: str, columns: dict[str, str], sources: dict[str, ColumnDataSource]) -> figure:
    plot = figure(
        title=title, tools=TOOLS, active_scroll=None, width=410, height=310, toolbar_location="above",
        min_border_left=58, x_axis_label="iteration", name=f"plot-{title.split(',')[0]}",
    )  # fmt: skip
    for number, ((column, label), colour) in enumerate(zip(columns.items(), cycle(Category10[10]), strict=False)):
        source = sources[column] = ColumnDataSource({"iteration": [], "value": []})
        dash = "solid" if number < 3 else "dashed"
        line = plot.line(
            "iteration", "value", color=colour, line_dash=dash, line_width=1.6, source=source, legend_label=label
        )  # fmt: skip
        points = plot.scatter("iteration", "value", color=colour, size=4, source=source, legend_label=label)
        told = [("", label), ("iteration", "@iteration"), ("value", "@value{%.5g}")]
        plot.add_tools(HoverTool(renderers=[line, points], tooltips=told, formatters={"@value": "printf"}))
    if title == _CENTRE:
        plot.y_range = Range1d()
    else:
        plot.y_range.start = 0.0
    legend = plot.legend[0]
    legend.update(
        label_text_font_size="10px", spacing=6, padding=2, margin=0, border_line_color=None, glyph_width=14, ncols=2,
        click_policy="hide", location="bottom_left",
    )  # fmt: skip
    plot.add_layout(legend, "below")
    plot.toolbar.update(logo=None, autohide=True)
    plot.xaxis.ticker.update(min_interval=1)
    plot.title.text_font_size = "13px"
    return plot
