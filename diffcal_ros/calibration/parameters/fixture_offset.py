# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How far a fixture is from where the scene states it beside the body."""

from dataclasses import replace

from diffcal_ros.calibration.parameters.parameter_layout import rigid_motion_parameters
from diffcal_ros.calibration.parameters.parameters import Kind, Parameter

# A body sits in its clamp to a millimetre in all of where drawings have both [m, rad].
_FIXTURE_STDS = (0.0006, 0.0006, 0.0006, 0.005, 0.005, 0.005)


def fixture_offset_parameters() -> list[Parameter]:
    """Lay out how far a fixture is from where it is stated beside the body, a nuisance."""
    return [
        replace(own, quantity=replace(own.quantity, prior_mean=0.0, prior_std=std))
        for own, std in zip(
            rigid_motion_parameters('fixture_offset', Kind.FIXTURE_OFFSET, 0),
            _FIXTURE_STDS,
            strict=True,
        )
    ]
