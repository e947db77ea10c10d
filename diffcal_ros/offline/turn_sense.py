# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which way was a clamp turned? Half a turn ends in the same place either way, the body does not.

A scene that turns a held part the wrong way round is met by no parameters: moduli run to their
bounds, and what is left looks like a fault of the sensor. The other sense is cheap to try.
"""

from collections.abc import Sequence
from dataclasses import replace
import math

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.results.result import CalibrationResult
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.errors import NotSimulatedError
from diffcal_ros.scene.model import HeldPart, ObservationSetup, Scene

# An odd number of half turns, so nearly that the end looks the same [rad].
_NEAR_HALF = math.radians(3.0)
# The other sense is believed where it leaves less than this share of the gap, on as many pixels.
_MUCH_LESS, _LOST = 0.6, 0.05


def half_turned(scene: Scene) -> tuple[str, ...]:
    """Return the names of the held parts that end half a turn away."""
    return tuple(
        dict.fromkeys(
            part.name for setup in scene.observations for part in setup.held if _is_half(part)
        )
    )


def other_sense(scene: Scene) -> Scene:
    """Return the scene with half turns made the other way round."""
    setups = tuple(_other_setup(setup) for setup in scene.observations)
    return replace(scene, observations=setups)


def sense_note(
    scene: Scene,
    observations: Sequence[Observation],
    settings: CalibrationSettings,
    result: CalibrationResult,
) -> str | None:
    """Fit with half turns made the other way; say so where that fits much better.

    Args:
        scene: of the fit.
        observations: of it.
        settings: of it.
        result: of it.

    Returns:
        What to tell, or None: no part is turned by half a turn, or it is turned the right way.
    """
    parts = half_turned(scene)
    if not parts:
        return None
    plain = replace(settings, with_mesh_error=False, profile=())
    try:
        other = Calibration(other_sense(scene), observations, plain).run()
    except NotSimulatedError:
        return None
    before, after = result.gap_end, other.gap_end
    if after.coverage < before.coverage - _LOST or not after.median < _MUCH_LESS * before.median:
        return None
    return (
        f'turned the other way round, {", ".join(parts)} would end in the same place, and the '
        f'median gap would be {1e3 * after.median:.2f} mm in place of {1e3 * before.median:.2f}: '
        "change the sign of angle_deg under 'turn'"
    )


def _is_half(part: HeldPart) -> bool:
    if part.turn is None:
        return False
    beyond = abs(part.turn.angle) % (2.0 * math.pi)
    return abs(beyond - math.pi) < _NEAR_HALF


def _other_setup(setup: ObservationSetup) -> ObservationSetup:
    held = tuple(
        replace(part, turn=replace(part.turn, angle=-part.turn.angle))
        if part.turn is not None and _is_half(part)
        else part
        for part in setup.held
    )
    return replace(setup, held=held)
