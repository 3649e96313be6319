"""The report's page in a real browser: it needs nothing else, and everything on it works."""

from __future__ import annotations

import re

import pytest
from chromium import Chromium, program
from comparisons import LPV

from octolux.compare.page import page as html_of

pytestmark = pytest.mark.skipif(program() is None, reason="needs chromium")


@pytest.fixture(scope="module")
def browser(report, tmp_path_factory):
    folder = tmp_path_factory.mktemp("page")
    report.write(folder / "out")
    with Chromium(folder / "profile") as opened:
        opened.load((folder / "out" / "report.html").as_uri())
        yield opened


def middle(browser, selector: str) -> tuple[float, float]:
    """Of an element in the window, scrolled to."""
    browser.run(f"document.querySelector({selector!r}).scrollIntoView({{block: 'center'}})")
    box = browser.run(f"document.querySelector({selector!r}).getBoundingClientRect().toJSON()")
    return box["left"] + box["width"] / 2, box["top"] + box["height"] / 2


def click(browser, selector: str) -> None:
    at = middle(browser, selector)
    browser.drag(at, at)


def choose(browser, name: str, value: str) -> None:
    click(browser, f"#{name} label:has(input[value={value}]) span")


def seen(browser, side: str) -> str:
    return browser.run(f"document.querySelector('#pane-{side} img').alt")


def test_it_asks_for_nothing_and_reports_no_errors(browser):
    asked = [e["params"]["request"]["url"] for e in browser.events if e["method"] == "Network.requestWillBeSent"]
    assert [url.partition(":")[0] for url in asked if not url.startswith("data:")] == ["file"]
    noise = {"Runtime.consoleAPICalled", "Runtime.exceptionThrown", "Log.entryAdded", "Network.loadingFailed"}
    assert [e for e in browser.events if e["method"] in noise] == []


def test_all_pictures_are_shown(browser):
    sizes = "Promise.all([...document.images].map(i => i.decode().then(() => [i.naturalWidth, i.naturalHeight])))"
    found = browser.run(sizes)
    assert len(found) > 8
    assert {tuple(size) for size in found} == {(48, 36)}


def test_the_slider_moves(browser):
    def split() -> str:
        return browser.run("getComputedStyle(document.getElementById('pane-right')).clipPath")

    before = split()
    x, y = middle(browser, "#handle")
    browser.drag((x, y), (x + 150, y))
    moved = split()
    assert moved != before
    now = int(browser.run("document.getElementById('handle').getAttribute('aria-valuenow')"))
    assert now > 50
    browser.run("document.getElementById('handle').focus()")
    browser.key("ArrowLeft")
    assert int(browser.run("document.getElementById('handle').getAttribute('aria-valuenow')")) == now - 2
    assert split() != moved


def test_layers_and_views(browser):
    assert seen(browser, "left") == f"{LPV}: final"
    assert seen(browser, "right").endswith(": final")
    hidden = "getComputedStyle(document.getElementById('legend')).display === 'none'"
    assert browser.run(hidden)
    source = "document.querySelector('#pane-left img').src"
    pictures = {browser.run(source)}
    choose(browser, "layer", "indirect")
    pictures.add(browser.run(source))
    for view, words in (("error", "100 % and more"), ("brightness", "100 % too dark")):
        choose(browser, "view", view)
        assert not browser.run(hidden)
        assert words in browser.run("document.getElementById('legend').textContent")
        assert "gradient" in browser.run("getComputedStyle(document.querySelector('#legend .bar')).backgroundImage")
        pictures.add(browser.run(source))
    assert seen(browser, "left") == f"{LPV}: indirect, too bright, too dark"
    assert seen(browser, "right").endswith(": indirect")  # the reference has no error
    assert len(pictures) == 4
    choose(browser, "view", "picture")
    choose(browser, "layer", "final")


def test_zoom_and_move(browser):
    transform = "document.querySelector('#pane-left img').style.transform"
    x, y = middle(browser, "#stage")
    browser.mouse("Wheel", x - 100, y, deltaX=0, deltaY=-400)
    browser.run("new Promise(requestAnimationFrame)")
    zoomed = browser.run(transform)
    assert float(re.search(r"scale\(([\d.]+)\)", zoomed)[1]) > 2.0
    browser.drag((x - 100, y), (x - 60, y + 30))
    assert browser.run(transform) != zoomed
    assert browser.run("document.querySelector('#pane-right img').style.transform") == browser.run(transform)
    click(browser, "#zoom-reset")
    assert "scale(1)" in browser.run(transform)
    click(browser, "#zoom-in")
    assert browser.run("document.getElementById('zoom').textContent") == "150 %"
    click(browser, "#zoom-reset")


def test_side_by_side(browser):
    choose(browser, "layout", "beside")
    left, right = middle(browser, "#pane-left"), middle(browser, "#pane-right")
    assert right[0] > left[0] + 300
    assert browser.run("getComputedStyle(document.getElementById('pane-right')).clipPath") == "none"
    choose(browser, "layout", "swipe")


def test_the_table_sorts_by_mouse_and_by_keyboard(browser):
    labels = "[...document.querySelectorAll('#table tbody th')].map(e => e.textContent.trim())"
    column = "[...document.querySelectorAll('#table tbody tr')].map(r => Number(r.cells[4].dataset.value))"
    heading = "#table thead tr:last-child th:nth-child(5)"
    first = browser.run(labels)
    assert first == [LPV, "constant", "black"]
    click(browser, f"{heading} button")
    up = browser.run(column)
    assert up == sorted(up)
    assert browser.run(f"document.querySelector('{heading}').getAttribute('aria-sort')") == "ascending"
    browser.run(f"document.querySelector('{heading} button').focus()")
    browser.key("Enter")
    assert browser.run(column) == up[::-1]
    assert browser.run(labels)[0] == "black"
    click(browser, "#table tbody tr:first-child .show")
    assert seen(browser, "left") == "black: final"


@pytest.mark.parametrize("width", [390, 320])
def test_it_fits_a_phone(browser, width):
    browser.resize(width, 844, mobile=True)
    try:
        for layout in ("swipe", "beside"):
            choose(browser, "layout", layout)
            assert browser.run("[document.documentElement.scrollWidth, innerWidth]") == [width, width]
            boxes = browser.run("[...document.querySelectorAll('.pane')].map(p => p.getBoundingClientRect().right)")
            assert max(boxes) <= width
    finally:
        choose(browser, "layout", "swipe")
        browser.resize(1280, 900)


def test_two_fingers_zoom(browser):
    x, y = middle(browser, "#stage")
    for kind, gap in (("touchStart", 40), ("touchMove", 80), ("touchMove", 120)):
        points = [{"x": x - gap, "y": y, "id": 0}, {"x": x + gap, "y": y, "id": 1}]
        browser.send("Input.dispatchTouchEvent", type=kind, touchPoints=points)
    browser.send("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
    assert browser.run("document.getElementById('zoom').textContent") == "300 %"
    click(browser, "#zoom-reset")


def test_words_from_outside_are_no_html(browser, report):
    """The command of the report holds a closing tag and an ampersand."""
    assert report.facts["command"] in browser.run("document.querySelector('pre').textContent")
    assert "</script> &" not in html_of(report)


def test_light_and_dark(browser):
    colours = set()
    for scheme in ("light", "dark"):
        browser.send("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
        colours.add(browser.run("getComputedStyle(document.body).backgroundColor"))
    assert len(colours) == 2
