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

from chromium import Chromium

from octolux.simulator.laboratory import Simulation
from octolux.viewer.simulate.server import server

SECONDS = 60.0  # a hang is a failure, not a wait


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
        self.until("window.Bokeh && Bokeh.documents.length && Bokeh.documents[0].is_idle")
        assert self.status() != ""

    def until(self, script: str) -> Any:
        """The script's value once it is true."""
        return self.until_here(lambda: self.browser.run(script), script)

    def until_here(self, value: Callable[[], Any], what: str = "") -> Any:
        """`value` once it is true."""
        end = time.monotonic() + SECONDS
        while not (found := value()):
            assert time.monotonic() < end, f"never true: {what}"
            time.sleep(0.05)
        return found

    def model(self, name: str, what: str) -> Any:
        """An expression of JavaScript about the model of that name."""
        return self.browser.run(f"Bokeh.documents[0].get_model_by_name({json.dumps(name)}).{what}")

    def status(self) -> str:
        return str(self.model("status", "text"))

    def middle(self, name: str, part: str) -> tuple[float, float]:
        """Of the part (a selector within the model's element) in the window, scrolled to, once it can be seen."""
        box = self.until(f"""(() => {{
            const model = Bokeh.documents[0].get_model_by_name({json.dumps(name)})
            const part = Bokeh.index.find_one(model).shadow_el.querySelector({json.dumps(part)})
            part.scrollIntoView({{block: "center"}})
            const box = part.getBoundingClientRect()
            return box.width > 0 ? box.toJSON() : null
        }})()""")
        return box["left"] + box["width"] / 2, box["top"] + box["height"] / 2

    def click(self, name: str, part: str = "button", says: str = "") -> None:
        """Press the mouse on it, and wait until the status says `says`."""
        at = self.middle(name, part)
        self.browser.drag(at, at)
        if says:
            self.until(f"Bokeh.documents[0].get_model_by_name('status').text.includes({json.dumps(says)})")

    def choose(self, name: str, value: str) -> None:
        """Choose in a list."""
        self.browser.run(f"""(() => {{
            const model = Bokeh.documents[0].get_model_by_name({json.dumps(name)})
            const list = Bokeh.index.find_one(model).shadow_el.querySelector("select")
            list.value = {json.dumps(value)}
            list.dispatchEvent(new Event("change"))
        }})()""")

    def type(self, name: str, text: str) -> None:
        """Replace what is in a field."""
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
