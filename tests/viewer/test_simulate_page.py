"""`octolux simulate --serve` in a real browser: light is injected, stepped, looked at and saved."""

from __future__ import annotations

import base64
import io

import numpy as np
import pytest
from PIL import Image

pytest.importorskip("bokeh")
from chromium import program
from pages import Page, opened

from octolux.simulator.laboratory import Element, Simulation, Wall, slices

pytestmark = pytest.mark.skipif(program() is None, reason="needs chromium")

N = 8


@pytest.fixture(scope="module")
def open_page(tmp_path_factory):
    with opened(lambda: Simulation(N, compare=["uniform"]), tmp_path_factory.mktemp("page")) as page:
        yield page


@pytest.fixture
def page(open_page):
    """Dark, with nothing in the sets, the default view."""
    return Page(open_page.browser, open_page.browser.run("location.href"))


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

    page.choose("level", "1")
    page.until("Bokeh.documents[0].get_model_by_name('grid-sum').title.text === 'sum, level 1'")
    coarse, _ = slices.polar_curves(slices.cut(expected.view("sum", 1), "z", N // 4), "z", 2.0)
    assert np.nanmax(curves(page, "sum")) == pytest.approx(coarse.max())

    page.click("axis", "button:first-child", says="looking at x = 4, level 1")
    page.until("Bokeh.documents[0].get_model_by_name('grid-sum').below[0].axis_label === 'z'")
    assert page.mistakes() == []


def test_the_plots_show_every_iteration(page):
    begin(page, 3)
    rows = stepped(3).state.measures
    plot = "plot-mean absolute error"
    lines = "renderers.filter(r => r.glyph.type === 'Line')"
    found = page.model(plot, f"{lines}.map(r => Array.from(r.data_source.data.value))")
    expected = [[row[name] for row in rows] for name in ("e_abs", "corrected_e_abs", "merged_abs")]
    assert found == expected
    assert [row["iteration"] for row in rows] == [0, 1, 2, 3]


def test_the_picture_shows_light(page):
    """Seen pixels: the grids are white before, and hold the colour of light after."""
    before = page.browser.picture(whole=False)
    begin(page, 1)
    after = page.browser.picture(whole=False)
    assert orange(before) == 0
    assert orange(after) > 500


def orange(png: bytes) -> int:
    """Pixels clearly redder than blue."""
    pixels = np.asarray(Image.open(io.BytesIO(png)).convert("RGB")).astype(int)
    return int(((pixels[..., 0] - pixels[..., 2]) > 40).sum())


def test_the_pointer_tells_coefficients_and_flux_of_a_cell(page):
    begin(page, 0)
    flux = page.model("grid-sum", "renderers.map(r => r.data_source).find(s => s.name === 'cells').data.flux[0]")
    assert flux == pytest.approx(1.0)  # of the wall's cells: a multiplier of 1 is 1 W
    x, y = page.browser.run("""(() => {
        const view = Bokeh.index.find_one(Bokeh.documents[0].get_model_by_name("grid-sum"))
        view.el.scrollIntoView({block: "center"})
        const box = view.el.getBoundingClientRect()
        return [box.left + view.frame.x_scale.compute(0.5),
                box.top + view.frame.y_scale.compute(4.5)]
    })()""")
    page.browser.mouse("Moved", x - 1, y - 1)
    page.browser.mouse("Moved", x, y)
    told = page.until("""(() => {
        const texts = []
        const walk = node => {
            if (node.shadowRoot) walk(node.shadowRoot)
            for (const child of node.children || []) walk(child)
            if (node.classList && node.classList.contains("bk-tooltip-row-value")) texts.push(node.textContent)
        }
        walk(document.body)
        return texts.length ? texts.join("|") : null
    })()""")
    assert "0, 4, 4" in told
    assert "1 W" in told


def test_undo_and_redo(page):
    begin(page, 1)
    page.click("undo", says="took back: accumulate")
    page.click("undo", says="took back: propagate")
    assert "iteration 0" in page.status()
    page.click("redo", says="did again: propagate")
    assert "iteration 1" in page.status()


def test_the_sets_and_the_whole_algorithm(page):
    page.click("add", says="an injector more")
    page.click("role", "button:last-child")
    page.choose("kind", "area")
    page.type("low", "4, 2, 2")
    page.type("high", "4, 6, 6")
    page.click("add", says="an occluder more")
    assert page.model("sets", "text") == "in the set: light 1, occluders 1"
    page.click("run", says="iteration 4")
    assert page.model("grid-sum", "renderers.map(r => r.data_source).find(s => s.name === 'blocks').data.u.length") > 0


def test_a_mistake_is_one_line_and_changes_nothing(page):
    page.choose("kind", "element")
    page.type("cell", "99, 0, 0")
    page.click("inject-it", says="is outside the volume")
    page.type("cell", "a, b")
    page.click("inject-it", says="the cell is")
    page.choose("kind", "file")
    page.click("inject-it", says="no file is chosen")
    assert page.model("history", "text") == "done: nothing yet"


def test_a_file_is_sent_and_injected(page, tmp_path):
    light = np.zeros((N, N, N, 4))
    light[3, 2, 1] = 1.0, 0.1, 0.2, 0.3
    np.savez(tmp_path / "light.npz", light=light)
    (tmp_path / "wrong.csv").write_text("x,y\n1,2\n")
    page.choose("kind", "file")
    page.send_file("file", tmp_path / "wrong.csv")
    page.click("inject-it", says="wrong.csv: ")
    assert str(tmp_path) not in page.status()
    page.send_file("file", tmp_path / "light.npz")
    page.click("inject-it", says="injected")
    page.click("accumulate", says="accumulate")
    page.model("slice", "value = 3")
    page.until("Bokeh.documents[0].get_model_by_name('status').text.includes('z = 3')")
    source = "renderers.map(r => r.data_source).find(s => s.name === 'cells').data"
    assert page.model("grid-sum", f"{source}['c1-1'][0]") == 0.1
    assert page.model("grid-sum", f"{source}.x.length") == 1


def test_another_size_begins_anew_and_keeps_the_injectors(page):
    page.click("add", says="an injector more")
    page.choose("n", "16")
    page.click("begin", says="n = 16")
    page.click("run", says="iteration 4")
    assert page.model("grid-source", "x_range.end") == 16
    assert page.model("sets", "text") == "in the set: light 1, occluders 0"


def test_another_propagator_and_factor_hold_from_the_next_step(page):
    begin(page, 1)
    page.choose("propagator", "thesis")
    page.until("Bokeh.documents[0].get_model_by_name('status').text.includes('thesis: another propagator')")
    page.type("factor", "1, 0.5, x")
    page.until("Bokeh.documents[0].get_model_by_name('status').text.includes('the factor is')")
    page.type("factor", "1, 0.5, 0.25, 0")
    page.until("Bokeh.documents[0].get_model_by_name('status').text.includes('another factor')")
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


def test_a_page_begins_with_what_a_script_made(tmp_path):
    def made() -> Simulation:
        simulation = Simulation(N, injectors=[Element((1, 2, 3))])
        simulation.run(2)
        return simulation

    with opened(made, tmp_path) as page:
        assert "iteration 2" in page.status()
        assert page.model("sets", "text") == "in the set: light 1, occluders 0"
