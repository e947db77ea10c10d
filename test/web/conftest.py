# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A fit of the recorded beam, its set-up page, and a server without a browser."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from diffcal_ros.cli.main import main
from diffcal_ros.web.proposed_setup import open_setup_page
from diffcal_ros.web.server import page_server
from diffcal_ros.web.setup_page import SetupPage
import pytest
from support.arranged_beam import arranged_beam, ArrangedBeam
from support.recorded_beam import MODULUS


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


@pytest.fixture(scope='module')
def beam(recorded_beam) -> ArrangedBeam:
    """The recorded beam as `diffcal init` proposes it; not to be changed."""
    return arranged_beam(recorded_beam, MODULUS)


@pytest.fixture
def page(server, beam, tmp_path) -> Iterator[SetupPage]:
    """The set-up page of the beam, which saves to `scene.yaml`."""
    own = open_setup_page(server, beam.inputs, beam.draft, tmp_path / 'scene.yaml')
    yield own
    own.close()
