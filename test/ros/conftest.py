# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Nodes on a DDS domain of their own, on this machine only."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
import fcntl
import os
from pathlib import Path
import secrets
import tempfile
from typing import Any

import pytest

pytest.importorskip('rclpy', reason='ROS 2 is not installed')

ROOT = Path(__file__).resolve().parents[2]
_QUIET = {
    'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
    'FASTRTPS_DEFAULT_PROFILES_FILE': str(ROOT / 'config' / 'fastdds_large_images.xml'),
}


@contextmanager
def _own_domain() -> Iterator[int]:
    """Take a domain that no other test of this machine has, for as long as it is used."""
    # Beyond 101 Linux may have given the ports away.
    domains = secrets.SystemRandom().sample(range(1, 102), 101)
    for domain in domains:
        path = Path(tempfile.gettempdir()) / f'diffcal_ros_domain_{domain}.{os.getuid()}.lock'
        with path.open('w') as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            yield domain
            return
    pytest.fail('other tests have taken all DDS domains')


@pytest.fixture(autouse=True)
def _quiet_domain(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    for name, value in _QUIET.items():
        if name not in os.environ:
            monkeypatch.setenv(name, value)
    with _own_domain() as domain:
        monkeypatch.setenv('ROS_DOMAIN_ID', str(domain))
        yield


@pytest.fixture
def make_bench(_quiet_domain: None) -> Iterator[Callable[..., Any]]:
    """`make_bench(parameters, arguments)` gives a probe on a fresh context."""
    from support.ros_bench import RosBench

    made: list[RosBench] = []

    def make(parameters: dict[str, Any] | None = None, arguments: Sequence[str] = ()) -> RosBench:
        made.append(RosBench(parameters or {}, arguments))
        return made[-1]

    yield make
    for bench in made:
        bench.close()


@pytest.fixture
def start_node(_quiet_domain: None, tmp_path: Path) -> Iterator[Callable[..., Any]]:
    """`start_node(name, parameters)` starts a node as a process; killed at the end if need be."""
    from support.ros_bench import NodeProcess

    started: list[NodeProcess] = []

    def start(name: str, parameters: dict[str, Any] | None = None) -> NodeProcess:
        log = tmp_path / f'{len(started)}_{name}.log'
        started.append(NodeProcess(name, parameters or {}, log))
        return started[-1]

    yield start
    for node in started:
        node.close()
