# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The server of a page: where it listens, and until when."""

from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from io import StringIO
import ipaddress
import socket
import threading
from typing import Any

from diffcal_ros.errors import InputError
from diffcal_ros.report.palette import FITTED
from diffcal_ros.web.stage import rgb

LOOPBACK, USUAL_PORT = '127.0.0.1', 8080
# From the usual port on, so many are tried.
_PORTS = 50
# Python looks at Ctrl-C so often [s].
_TICK = 0.2


@contextmanager
def page_server(host: str, port: int | None) -> Iterator[Any]:
    """Serve an empty page, of viser, until the block ends.

    Args:
        host: name or address to listen at; only this machine reaches 127.0.0.1.
        port: to listen at; 0: any that is free; None: the first free one from 8080 on.

    Raises:
        InputError: when viser is missing, or nothing can listen there.
    """
    try:
        import viser
    except ImportError as error:
        raise InputError(
            "pages in the browser need viser: python -m pip install 'diffcal_ros[web]', or viser"
        ) from error
    with redirect_stdout(StringIO()):  # Where the page is, we say ourselves.
        server = viser.ViserServer(host=host, port=free_port(host, port), verbose=False)
    try:
        server.gui.configure_theme(
            control_width='large',
            show_logo=False,
            show_share_button=False,
            brand_color=rgb(FITTED),
        )
        server.gui.main_panel.dock_right()
        yield server
    finally:
        with redirect_stdout(StringIO()):
            server.stop()


def free_port(host: str, port: int | None) -> int:
    """Return a port at which a server can listen.

    Args:
        host: name or address.
        port: the one that is asked for; 0: any; None: the first free one from 8080 on.

    Raises:
        InputError: when it is taken, or `host` is not of this machine.
    """
    wanted = range(USUAL_PORT, USUAL_PORT + _PORTS) if port is None else (port,)
    fault: OSError | None = None
    for own in wanted:
        try:
            return _bound(host, own)
        except (OSError, OverflowError) as error:
            fault = error if isinstance(error, OSError) else OSError('ports end at 65535')
            if isinstance(error, socket.gaierror):
                break
    places = f'port {port}' if port is not None else f'a port from {USUAL_PORT} on'
    reason = '' if fault is None else f' ({fault.strerror or fault})'
    raise InputError(
        f'nothing can listen at {host}, {places}{reason}: give another --port, or an address of '
        'this machine as --host'
    )


def _bound(host: str, port: int) -> int:
    """Bind a port for a moment; return its number."""
    family, kind, protocol, _, address = socket.getaddrinfo(
        host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
    )[0]
    with socket.socket(family, kind, protocol) as own:
        own.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        own.bind(address)
        return int(own.getsockname()[1])


def is_loopback(host: str) -> bool:
    """Tell whether only this machine reaches an address."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == 'localhost'


def wait_for_interrupt(ended: threading.Event | None = None) -> None:
    """Return at Ctrl-C, or when a page says that it is done."""
    ended = ended or threading.Event()
    try:
        while not ended.wait(_TICK):
            pass
    except KeyboardInterrupt:
        return
