# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where a page is served."""

import socket
from urllib.error import URLError
from urllib.request import urlopen

from diffcal_ros.errors import InputError
from diffcal_ros.web.server import free_port, is_loopback, page_server
import pytest


def test_a_taken_port_is_told_and_the_usual_ones_are_tried_in_turn():
    with socket.socket() as taken:
        taken.bind(('127.0.0.1', 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(InputError, match=f'port {port}.*--port'):
            free_port('127.0.0.1', port)
        assert free_port('127.0.0.1', 0) != port
        assert 8080 <= free_port('127.0.0.1', None) < 8130


def test_an_address_of_another_machine_is_told():
    with pytest.raises(InputError, match=r'nothing can listen at 192\.0\.2\.1'):
        free_port('192.0.2.1', None)


@pytest.mark.parametrize(
    ('host', 'expected'),
    [('127.0.0.1', True), ('::1', True), ('localhost', True), ('0.0.0.0', False)],
)
def test_who_reaches_an_address(host, expected):
    assert is_loopback(host) is expected


def test_a_page_listens_where_it_is_asked_to_and_ends(capsys):
    pytest.importorskip('viser', reason='viser is not installed: pip install viser')
    with page_server('127.0.0.1', 0) as server:
        assert server.get_host() == '127.0.0.1'
        address = f'http://127.0.0.1:{server.get_port()}'
        with urlopen(address, timeout=60) as answer:
            assert b'<html' in answer.read()
    with pytest.raises(URLError):
        urlopen(address, timeout=1)
    assert capsys.readouterr().out == ''
