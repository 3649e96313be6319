"""`octolux simulate --serve` in a real browser: light is injected, stepped, looked at and saved."""

from __future__ import annotations

import base64
import io

import numpy as np
import pytest
from PIL import Image

pytest.importorskip("bokeh")
from bokeh.document import Document
from chromium import Chromium, program
from pages import Page, served

from octolux.simulator.laboratory import Element, Simulation, Wall, slices
from octolux.viewer.simulate.page import fill

pytestmark = pytest.mark.skipif(program() is None, reason="needs chromium")

N = 8


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    """One for all tests; each loads a page, and so has a simulation of its own."""
    with Chromium(tmp_path_factory.mktemp("browser") / "profile", (1600, 1100)) as started:
        yield started


@pytest.fixture(scope="module")
def address():
    with served(lambda: Simulation(N, compare=["uniform"])) as found:
        yield found


@pytest.fixture
def page(browser, address):
    """Dark, with nothing in the sets, the default view. What it reports as an error fails the test."""
    opened = Page(browser, address)
    yield opened
    assert opened.mistakes() == []


def stepped(times: int) -> Simulation:
    """What the buttons do, without a page."""
    simulation = Simulation(N, compare=["uniform"])
    simulation.inject(Wall("x"))
    simulation.downsample()
    simulation.accumulate()
    for _ in range(times):
        simulation.propagate()
        simulation.accumulate()
    return simulation


def begin(page: Page, steps: int) -> None:
    """A wall is injected and stepped, with real clicks."""
    page.click("inject-it", says="injected")
    page.click("downsample", says="downsample")
    page.click("accumulate", says="accumulate")
    for number in range(1, steps + 1):
        page.click("step", says=f"iteration {number}")


def curves(page: Page, name: str) -> np.ndarray:
    """The curves' points (2, ...) that the grid `name` has in the browser; NaN between the curves."""
    source = "renderers.map(r => r.data_source).find(s => s.name === 'curves')"
    take = "Array.from(values, value => Number.isNaN(value) ? null : value)"
    columns = f"{source}.data).map(([name, values]) => [name, {take}])"
    grid = f"Bokeh.documents[0].get_model_by_name('grid-{name}')"
    found = page.browser.run(f"Object.fromEntries(Object.entries({grid}.{columns})")
    return np.array([found["u"], found["v"]], dtype=np.float64)


def test_a_wall_is_injected_stepped_and_looked_at_level_by_level(page):
    begin(page, 3)
    expected = stepped(3)
    plane = slices.cut(expected.view("sum"), "z", N // 2)
    drawn, _ = slices.polar_curves(plane, "z")
    whole = np.concatenate([drawn, np.full((len(drawn), 1, 2), np.nan)], axis=1).reshape(-1, 2).T
    assert np.allclose(curves(page, "sum"), whole, equal_nan=True)
    assert ticks(page) == [[0, 1, 2, 3, 4, 5, 6, 7, 8]] * 4
    assert plotted(page) == [[row[name] for row in expected.state.measures] for name in ERRORS]

    page.choose("level", "1", says="level 1")
    assert page.model("grid-sum", "title.text") == "sum, level 1"
    coarse, _ = slices.polar_curves(slices.cut(expected.view("sum", 1), "z", N // 4), "z", 2.0)
    assert np.nanmax(curves(page, "sum")) == pytest.approx(coarse.max())
    assert ticks(page) == [[0, 2, 4, 6, 8]] * 4

    page.click("axis", "button:first-child", says="looking at x = 4, level 1")
    assert page.model("grid-sum", "below[0].axis_label") == "z"


ERRORS = ("e_abs", "corrected_e_abs", "merged_abs")


def plotted(page: Page) -> list[list[float]]:
    """The lines of `ERRORS`, iteration by iteration."""
    lines = "renderers.filter(r => r.glyph.type === 'Line')"
    return page.model("plot-mean absolute error", f"{lines}.map(r => Array.from(r.data_source.data.value))")


def ticks(page: Page) -> list[list[int]]:
    """Where the sum's grid has its two axes' labels and its lines."""
    view = "Bokeh.index.find_one(Bokeh.documents[0].get_model_by_name('grid-sum'))"
    parts = "view.model.below.concat(view.model.left, view.model.center).filter(p => 'ticker' in p)"
    return page.browser.run(f"(view => {parts}.map(part => Array.from(part.ticker.ticks)))({view})")


def test_light_is_seen_told_by_the_pointer_undone_and_redone(page):
    """Seen pixels: the grids are white before, and hold the colour of light after."""
    assert orange(page) == 0
    begin(page, 0)
    page.until_here(lambda: orange(page) > 500, "the colour of light")
    flux = page.model("grid-sum", "renderers.map(r => r.data_source).find(s => s.name === 'cells').data.flux[0]")
    assert flux == pytest.approx(1.0)  # of the wall's cells: a multiplier of 1 is 1 W
    told = page.until_here(lambda: page.pointed_at("grid-sum", 0.5, 4.5), "the pointer's words")
    assert "0, 4, 4" in told
    assert "1 W" in told

    page.click("step", says="iteration 1")
    page.click("undo", says="took back: accumulate")
    page.click("undo", says="took back: propagate")
    assert "iteration 0" in page.status()
    assert plotted(page) == [[row[name] for row in stepped(0).state.measures] for name in ERRORS]
    page.click("redo", says="did again: propagate")
    assert "iteration 1" in page.status()


def orange(page: Page) -> int:
    """Pixels of the window clearly redder than blue."""
    pixels = np.asarray(Image.open(io.BytesIO(page.browser.picture(whole=False))).convert("RGB")).astype(int)
    return int(((pixels[..., 0] - pixels[..., 2]) > 40).sum())


def test_the_sets_the_whole_algorithm_and_another_size(page):
    page.click("add", says="an injector more")
    page.click("role", "button:last-child")
    page.shape("area")
    page.type("low", "4, 2, 2")
    page.type("high", "4, 6, 6")
    page.click("add", says="an occluder more")
    assert page.model("sets", "text") == "in the set: light 1, occluders 1"
    page.click("run", says="iteration 4")
    assert page.model("grid-sum", "renderers.map(r => r.data_source).find(s => s.name === 'blocks').data.u.length") > 0

    page.click("remove", says="an occluder less")
    page.choose("n", "16")
    page.click("begin", says="n = 16")
    page.click("run", says="iteration 4")
    assert page.model("grid-source", "x_range.end") == 16
    assert page.model("sets", "text") == "in the set: light 1, occluders 0"


def test_a_mistake_is_one_line_and_changes_nothing_and_a_file_is_injected(page, tmp_path):
    page.shape("element")
    page.type("cell", "99, 0, 0")
    page.click("inject-it", says="is outside the volume")
    page.type("cell", "a, b")
    page.click("inject-it", says="the cell is")
    page.shape("file")
    page.click("inject-it", says="no file is chosen")
    (tmp_path / "wrong.csv").write_text("x,y\n1,2\n")
    page.send_file("file", tmp_path / "wrong.csv")
    page.click("inject-it", says="wrong.csv: ")
    assert str(tmp_path) not in page.status()
    assert page.model("history", "text") == "done: nothing yet"

    light = np.zeros((N, N, N, 4))
    light[3, 2, 1] = 1.0, 0.1, 0.2, 0.3
    np.savez(tmp_path / "light.npz", light=light)
    page.send_file("file", tmp_path / "light.npz")
    page.click("inject-it", says="injected")
    page.click("accumulate", says="accumulate")
    with page.saying("z = 3"):
        page.model("slice", "value = 3")
    source = "renderers.map(r => r.data_source).find(s => s.name === 'cells').data"
    assert page.model("grid-sum", f"{source}['c1-1'][0]") == 0.1
    assert page.model("grid-sum", f"{source}.x.length") == 1


def test_another_propagator_and_factor_hold_from_the_next_step(page):
    begin(page, 1)
    page.choose("propagator", "thesis", says="thesis: another propagator")
    page.type("factor", "1, 0.5, x", says="the factor is")
    page.type("factor", "1, 0.5, 0.25, 0", says="another factor")
    page.click("step", says="iteration 2")
    expected = stepped(1)
    expected.set_propagator("thesis")
    expected.set_factor([1.0, 0.5, 0.25, 0.0])
    expected.propagate()
    expected.accumulate()
    rows = page.model("plot-flux", "renderers[0].data_source.data.value")
    assert list(rows.values() if isinstance(rows, dict) else rows) == [r["step_flux"] for r in expected.state.measures]
    page.choose("n", "16")
    page.click("begin", says="n = 16")
    assert "thesis" in page.status()
    assert page.model("factor", "value") == "1"  # its first level's: there are more levels now


def test_everything_can_be_saved(page, tmp_path):
    page.browser.send("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(tmp_path))
    begin(page, 1)
    for name in ("slices.png", "errors.png", "errors.csv", "state.npz"):
        page.click(name, says=f"saved {name}")
        data = page.browser.run("JSON.parse(Bokeh.documents[0].get_model_by_name('carrier').text).data")
        sent = base64.b64decode(data)
        page.until_here((tmp_path / name).exists)
        assert (tmp_path / name).read_bytes() == sent
    with np.load(tmp_path / "state.npz") as arrays:
        assert np.array_equal(arrays["sum_0"], stepped(1).state.sum[0])


def test_a_page_begins_with_what_a_script_made(browser):
    def made() -> Simulation:
        simulation = Simulation(N, injectors=[Element((1, 2, 3))])
        simulation.run(2)
        return simulation

    with served(made) as address:
        page = Page(browser, address)
        assert "iteration 2" in page.status()
        assert page.model("sets", "text") == "in the set: light 1, occluders 0"


def test_a_redraw_makes_no_parts():
    """For each new one Bokeh searches the whole page for others, longer than all that is drawn takes."""
    document = Document()
    laboratory = fill(document, Simulation(N))
    before = {model.id for model in document.models}
    laboratory.inject(lambda: Wall("x"))
    laboratory.look(axis="x", index=2, level=1)
    laboratory.step()
    assert {model.id for model in document.models} == before
