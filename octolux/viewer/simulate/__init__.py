"""The laboratory of light propagation volumes in the browser: `octolux simulate --serve`.

Needs Bokeh (`pip install "octolux[ui]"`); only `server` is imported before that is known to be there.
"""

HOST, PORT = "127.0.0.1", 5006
"""Where the page is served unless told otherwise: for this machine alone."""
