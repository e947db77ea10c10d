# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The executable `calibration`."""

from collections.abc import Sequence

from diffcal_ros.ros.run_node import run_node


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the calibration node; return the exit code."""
    return run_node('diffcal_ros.ros.calibration', 'CalibrationNode', arguments)
