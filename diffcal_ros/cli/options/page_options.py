# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where a page in the browser is served, and what is said about it."""

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from diffcal_ros.cli.say import say

_LOOPBACK = '127.0.0.1'


def add_page_options(group: Any) -> None:
    """Add address and port."""
    group.add_argument(
        '--port',
        metavar='N',
        type=_port,
        help='of the page (default: the first free from 8080 on)',
    )
    group.add_argument(
        '--host',
        metavar='ADDRESS',
        default=_LOOPBACK,
        help=f'to serve the page at (default: {_LOOPBACK}, which only this machine reaches)',
    )


@contextmanager
def asked_page(args: argparse.Namespace) -> Iterator[Any]:
    """Serve an empty page; say where it is once the block goes on to wait, see `say_where`.

    Raises:
        InputError: when viser is missing, or nothing can listen there.
    """
    from diffcal_ros.web.server import page_server

    with page_server(args.host, args.port) as server:
        yield server


def say_where(server: Any) -> None:
    """Say how to open a page, and who can."""
    from diffcal_ros.web.server import is_loopback

    host, port = server.get_host(), server.get_port()
    if not is_loopback(host):
        say(f'note: whoever reaches {host} can open and use this page')
    if host in ('0.0.0.0', '::'):
        host = 'localhost'
    place = f'[{host}]' if ':' in host else host
    say(f'open http://{place}:{port} in a browser; Ctrl-C ends')


def _port(text: str) -> int:
    try:
        port = int(text)
    except ValueError:
        port = -1
    if not 0 <= port <= 65535:
        raise argparse.ArgumentTypeError(f'{text!r} is no port, 1 to 65535, or 0 for any')
    return port
