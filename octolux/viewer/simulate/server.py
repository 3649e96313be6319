"""The server of the page. Everybody who opens it has a simulation of their own."""

from __future__ import annotations

import errno
from collections.abc import Callable
from typing import TYPE_CHECKING

from octolux.scene.errors import OctoluxError
from octolux.simulator.laboratory import Simulation

from . import HOST, PORT

if TYPE_CHECKING:
    from bokeh.document import Document
    from bokeh.server.server import Server


def server(make: Callable[[], Simulation], host: str = HOST, port: int = PORT) -> Server:
    """A server that listens at `host` and `port` (0: any that is free) and answers once its io_loop is started.

    make: gives the simulation that a page begins with. Only pages that this server sent may talk to it.
    Raises OctoluxError: Bokeh is missing, the port is taken, the host is not one of this machine.
    """
    try:
        from bokeh.application import Application
        from bokeh.application.handlers import FunctionHandler
        from bokeh.server.server import Server
        from bokeh.server.util import bind_sockets
    except ImportError as error:
        raise OctoluxError('The page needs Bokeh. Install it: pip install "octolux[ui]".') from error
    from .page import fill

    def opened(document: Document) -> None:
        fill(document, make())

    try:
        sockets, bound = bind_sockets(host, port)
        for socket in sockets:
            socket.close()
        # Of a server for all comers the name that they reach it by is not known; its port is.
        names = [host, "localhost"] if host == HOST else ["*"]
        return Server(
            Application(FunctionHandler(opened)), address=host, port=bound, index=None,
            allow_websocket_origin=[f"{name}:{bound}" for name in names],
        )  # fmt: skip
    except (OSError, UnicodeError) as error:
        raise OctoluxError(_refusal(error, host, port)) from error


def _refusal(error: OSError | UnicodeError, host: str, port: int) -> str:
    number = getattr(error, "errno", None)
    if number == errno.EADDRINUSE:
        return f"Port {port} of {host} is taken. Give another with --port; --port 0 takes any that is free."
    if number == errno.EACCES:
        return f"Port {port} of {host} is not allowed. Give one of 1024 or more with --port."
    return f"'{host}' is no address of this machine ({getattr(error, 'strerror', None) or error}). Use --host {HOST}."


def serve(make: Callable[[], Simulation], host: str, port: int, ready: Callable[[str], None]) -> None:
    """Serve until interrupted. ready: called with the page's address. Raises OctoluxError as `server`."""
    running = server(make, host, port)
    running.start()
    ready(f"http://{host}:{running.port}/")
    try:
        running.io_loop.start()
    except KeyboardInterrupt:
        running.stop()
