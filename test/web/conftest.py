# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A fit of the recorded beam, and a server without a browser."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from diffcal_ros.cli.main import main
from diffcal_ros.web.server import page_server
import pytest


@dataclass(frozen=True)
class FittedBeam:
    """The folder of a fit, and what it was made from; not to be changed."""

    folder: Path
    bag: Path


@pytest.fixture(scope='session')
def fitted_beam(recorded_beam, tmp_path_factory) -> FittedBeam:
    folder, bag = tmp_path_factory.mktemp('web') / 'fit', recorded_beam.bags['observation']
    quick = ('--no-search', '--no-mesh-error')
    scene = ('--scene', str(recorded_beam.scene), '--out', str(folder))
    assert main(['calibrate', str(bag), *scene, *quick]) == 0
    return FittedBeam(folder, bag)


@pytest.fixture
def server() -> Iterator[Any]:
    pytest.importorskip('viser', reason='viser is not installed: pip install viser')
    with page_server('127.0.0.1', 0) as own:
        yield own
