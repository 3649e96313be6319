"""The laboratory's page in a real browser: its parts are found by the names of their models."""

from __future__ import annotations

import asyncio
import json
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from chromium import SECONDS, Chromium

from octolux.simulator.laboratory import Simulation
from octolux.viewer.simulate.server import server
from octolux.viewer.simulate.shapes import KINDS


@contextmanager
def served(make: Callable[[], Simulation]) -> Iterator[str]:
    """The address of a page that begins with what `make` gives, served by a thread of its own."""
    started: list[Any] = []
    listening = threading.Event()

    def run() -> None:
        asyncio.set_event_loop(asyncio.new_event_loop())
        started.append(server(make, port=0))
        started[0].start()
        started[0].io_loop.add_callback(listening.set)
        started[0].io_loop.start()

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    assert listening.wait(SECONDS)
    yield f"http://127.0.0.1:{started[0].port}/"
    started[0].io_loop.add_callback(started[0].io_loop.stop)
    thread.join(SECONDS)


class Page:
    """An open page."""

    def __init__(self, browser: Chromium, address: str):
        self.browser = browser
        browser.events.clear()
        browser.load(address)
        self.until("window.Bokeh && Bokeh.documents.length > 0 && Bokeh.documents[0].is_idle")
        assert self.status() != ""
        self.browser.run("""(() => {
            const status = Bokeh.documents[0].get_model_by_name("status")
            window.said = []
            status.properties.text.change.connect(() => said.push(status.text))
        })()""")

    def until(self, script: str) -> Any:
        """The script's value once it is true."""
        return self.until_here(lambda: self.browser.run(script), script)

    def until_here(self, value: Callable[[], Any], what: str = "") -> Any:
        """`value` once it is true."""
        end = time.monotonic() + SECONDS
        while not (found := value()):
            assert time.monotonic() < end, f"never true: {what}"
            time.sleep(0.02)
        return found

    def model(self, name: str, what: str) -> Any:
        """An expression of JavaScript about the model of that name."""
        return self.browser.run(f"Bokeh.documents[0].get_model_by_name({json.dumps(name)}).{what}")

    def status(self) -> str:
        return str(self.model("status", "text"))

    @contextmanager
    def saying(self, words: str) -> Iterator[None]:
        """Do something, and wait until it has made the status say `words`; what it said before does not count."""
        self.browser.run("said.length = 0")
        yield
        if words:
            self.until(f"said.some(text => text.includes({json.dumps(words)}))")

    def middle(self, name: str, part: str) -> tuple[float, float]:
        """Of the part (a selector within the model's element) in the window, scrolled to, once it is seen and rests."""
        box = self.until(f"""(async () => {{
            const model = Bokeh.documents[0].get_model_by_name({json.dumps(name)})
            const part = Bokeh.index.find_one(model).shadow_el.querySelector({json.dumps(part)})
            part.scrollIntoView({{block: "center"}})
            const before = JSON.stringify(part.getBoundingClientRect())
            for (let frame = 0; frame < 2; frame++) await new Promise(requestAnimationFrame)
            const box = part.getBoundingClientRect()
            const rests = Bokeh.documents[0].is_idle && JSON.stringify(box) === before
            return rests && box.width > 0 ? box.toJSON() : null
        }})()""")
        return box["left"] + box["width"] / 2, box["top"] + box["height"] / 2

    def click(self, name: str, part: str = "button", says: str = "") -> None:
        """Press the mouse on it, and wait until that has made the status say `says`."""
        with self.saying(says):
            at = self.middle(name, part)
            self.browser.drag(at, at)

    def choose(self, name: str, value: str, says: str = "") -> None:
        """Choose in a list, and wait as `click` does."""
        with self.saying(says):
            self.browser.run(f"""(() => {{
                const model = Bokeh.documents[0].get_model_by_name({json.dumps(name)})
                const list = Bokeh.index.find_one(model).shadow_el.querySelector("select")
                list.value = {json.dumps(value)}
                list.dispatchEvent(new Event("change"))
            }})()""")

    def shape(self, kind: str) -> None:
        """Choose the kind of shape, and wait until its fields alone are seen: the others' going moves the page."""
        self.choose("kind", kind)
        shown = {
            f"wall-{field}" if owner == "wall" else field: kind == owner
            for owner, fields in KINDS.items() for field in fields
        }  # fmt: skip
        self.until(f"""Object.entries({json.dumps(shown)}).every(
            ([name, seen]) => Bokeh.documents[0].get_model_by_name(name).visible === seen)""")

    def type(self, name: str, text: str, says: str = "") -> None:
        """Replace what is in a field, and wait as `click` does."""
        with self.saying(says):
            at = self.middle(name, "input")
            self.browser.mouse("Pressed", *at, button="left", clickCount=3)
            self.browser.mouse("Released", *at, button="left", clickCount=3)
            self.browser.send("Input.insertText", text=text)
            self.browser.key("Enter")

    def send_file(self, name: str, path: Path) -> None:
        """Choose a file, and wait until the page holds it."""
        self.middle(name, "input")
        part = f"Bokeh.index.find_one(Bokeh.documents[0].get_model_by_name({json.dumps(name)})).shadow_el"
        found = self.browser.send("Runtime.evaluate", expression=f"{part}.querySelector('input')")
        chosen = found["result"]["objectId"]
        self.browser.send("DOM.setFileInputFiles", files=[str(path)], objectId=chosen)
        file = f"Bokeh.documents[0].get_model_by_name({json.dumps(name)})"
        self.until(f"{file}.properties.filename.is_unset === false && {file}.filename === {json.dumps(path.name)}")

    def pointed_at(self, name: str, u: float, v: float) -> str:
        """Point at that place of a drawing. What the page tells of it by then; "" while it tells nothing."""
        x, y = self.browser.run(f"""(() => {{
            const view = Bokeh.index.find_one(Bokeh.documents[0].get_model_by_name({json.dumps(name)}))
            view.el.scrollIntoView({{block: "center"}})
            const box = view.el.getBoundingClientRect()
            return [box.left + view.frame.x_scale.compute({u}), box.top + view.frame.y_scale.compute({v})]
        }})()""")
        self.browser.mouse("Moved", x - 1, y - 1)
        self.browser.mouse("Moved", x, y)
        return self.browser.run("""(() => {
            const texts = []
            const walk = node => {
                if (node.shadowRoot) walk(node.shadowRoot)
                for (const child of node.children || []) walk(child)
                if (node.classList && node.classList.contains("bk-tooltip-row-value")) texts.push(node.textContent)
            }
            walk(document.body)
            return texts.join("|")
        })()""")

    def mistakes(self) -> list[str]:
        """What the page reported as errors."""
        wrong = [event for event in self.browser.events if event.get("method") == "Runtime.exceptionThrown"]
        logged = [
            event for event in self.browser.events
            if event.get("method") == "Runtime.consoleAPICalled" and event["params"]["type"] == "error"
        ]  # fmt: skip
        return [json.dumps(event)[:400] for event in wrong + logged]


@contextmanager
def opened(make: Callable[[], Simulation], folder: Path) -> Iterator[Page]:
    """A page with what `make` gives, in a browser of its own."""
    with served(make) as address, Chromium(folder / "profile", (1600, 1100)) as browser:
        yield Page(browser, address)
