# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""An experiment in a file."""

from pathlib import Path

import pytest
from support.recorded_beam import write_beam_scene
from support.small_row import ROW
import yaml


@pytest.fixture
def row_file(tmp_path: Path) -> Path:
    """The experiment's YAML file."""
    write_beam_scene(tmp_path)
    path = tmp_path / 'small.yaml'
    path.write_text(yaml.safe_dump(ROW))
    return path
