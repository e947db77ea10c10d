# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""An experiment in a file."""

from pathlib import Path

import pytest
from support.small_row import write_row


@pytest.fixture
def row_file(tmp_path: Path) -> Path:
    """The experiment's YAML file."""
    return write_row(tmp_path)
