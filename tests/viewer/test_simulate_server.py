"""`octolux simulate --serve` and `--flatland`: one clear error for each mistake, and an end on Ctrl+C."""

from __future__ import annotations

import csv
import os
import signal
import socket
import subprocess
import sys
import urllib.request

import pytest
from chromium import SECONDS
from PIL import Image

from octolux.cli import main
from octolux.scene.errors import OctoluxError
from octolux.simulator.laboratory import Simulation, SimulationError
from octolux.viewer.simulate import HOST, entries
from octolux.viewer.simulate.server import server


def error_of(capsys, monkeypatch, *words: str) -> str:
    """What `octolux simulate` says when it refuses."""
    monkeypatch.setattr(sys, "argv", ["octolux", "simulate", *words])
    with pytest.raises(SystemExit) as stop:
        main()
    assert stop.value.code == 2
    return " ".join(capsys.readouterr().err.split())


def test_a_taken_port_is_one_clear_error(capsys, monkeypatch):
    with socket.create_server((HOST, 0)) as taken:
        port = taken.getsockname()[1]
        said = error_of(capsys, monkeypatch, "--serve", "--port", str(port))
    assert said == (
        f"error: Port {port} of 127.0.0.1 is taken. Give another with --port; --port 0 takes any that is free."
    )


@pytest.mark.parametrize("host", ["192.0.2.1", "no.such.host.invalid", "a..b"])
def test_a_host_that_is_not_here_is_one_clear_error(host):
    pytest.importorskip("bokeh")
    with pytest.raises(OctoluxError, match="is no address of this machine"):
        server(lambda: Simulation(8), host, 0)


def test_without_bokeh_the_error_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "bokeh.application", None)
    with pytest.raises(OctoluxError, match=r'pip install "octolux\[ui\]"'):
        server(lambda: Simulation(8))


@pytest.mark.parametrize(("words", "says"), [
    ((), "There is no script to run"),
    (("--serve", "missing.toml"), "missing.toml: cannot be read"),
    (("--flatland", "--serve"), "--flatland takes no script and has no page"),
    (("--flatland", "--bands", "2,x"), "--bands takes whole numbers"),
    (("--flatland", "--bands", "0"), "bands are different numbers from 1 to 256"),
])  # fmt: skip
def test_options_that_do_not_fit(words, says, capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    assert says in error_of(capsys, monkeypatch, *words)
    assert not list(tmp_path.iterdir())


def test_flatland_writes_its_picture_and_table(monkeypatch, tmp_path):
    words = ["simulate", "--flatland", "--bands", "2", "--out", str(tmp_path / "out")]
    monkeypatch.setattr(sys, "argv", ["octolux", *words])
    with pytest.raises(SystemExit) as stop:
        main()
    assert stop.value.code == 0
    with Image.open(tmp_path / "out" / "flatland.png") as picture:
        assert picture.width > 400
    rows = list(csv.DictReader((tmp_path / "out" / "flatland.csv").open()))
    assert {row["scheme"] for row in rows} == {"DOM4", "DOM8", "LPV", "LPV integral"}


def test_the_page_is_served_until_it_is_stopped():
    pytest.importorskip("bokeh")
    words = [sys.executable, "-c", "from octolux.cli import main; main()", "simulate", "--serve", "--port", "0"]
    environment = {**os.environ, "PYTHONUNBUFFERED": "1", "COLUMNS": "200"}
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment) as running:
        assert running.stdout is not None
        line = running.stdout.readline()
        address = next(word for word in line.split() if word.startswith("http://127.0.0.1:"))
        with urllib.request.urlopen(address, timeout=SECONDS) as answer:
            assert b"<title>octolux simulate</title>" in answer.read()
        running.send_signal(signal.SIGINT)
        _, errors = running.communicate(timeout=SECONDS)
    assert running.returncode in (0, 130)
    assert "Traceback" not in errors


def test_another_site_may_not_talk_to_it():
    pytest.importorskip("bokeh")
    made = server(lambda: Simulation(8), port=0)
    try:
        assert made._tornado.websocket_origins == {f"127.0.0.1:{made.port}", f"localhost:{made.port}"}
    finally:
        made._http.stop()
        made.io_loop.close()


@pytest.mark.parametrize("call", [
    lambda: entries.cell("the cell", "1, 2"), lambda: entries.cell("the cell", "1, 2, 3.5"),
    lambda: entries.numbers("p", "1; 2"), lambda: entries.direction("1, 0"), lambda: entries.factor(" "),
    lambda: entries.uploaded("", "", 8, "light", 1.0), lambda: entries.uploaded("a.csv", "?", 8, "light", 1.0),
])  # fmt: skip
def test_what_is_typed_wrongly(call):
    with pytest.raises(SimulationError):
        call()


def test_what_is_typed_well():
    assert entries.cell("the cell", " 1 2,3 ") == (1, 2, 3)
    assert entries.direction("0, -1, 0.5") == (0.0, -1.0, 0.5)
    assert entries.direction("all") == "all"
    assert entries.direction("") is None
    assert entries.factor("0.5") == 0.5
    assert entries.factor("1, 0.5, 0.25") == [1.0, 0.5, 0.25]
