# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A region that no camera sees cannot be fitted."""

from dataclasses import replace

from diffcal_ros.calibration.calibrate import calibrate
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.errors import InputError
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.scene.model import Scene
import numpy as np
import pytest
from support.scenes import beam_scene, CAMERA, observation, true_depth

_QUICK = CalibrationSettings(max_iterations=1, with_mesh_error=False)
# The border of the regions is tilted in the image by some ten pixels.
_MARGIN = 30


@pytest.fixture(scope='module')
def depth() -> np.ndarray:
    return true_depth()


def _with_tip_masked(depth: np.ndarray, element: Element) -> Scene:
    """A beam of two regions, clamped on the image's right, with the left half masked."""
    columns = np.flatnonzero(np.isfinite(depth).any(axis=0))
    right = int(columns[0] + columns[-1]) // 2 + _MARGIN
    scene = replace(beam_scene((8, 2, 2), region_count=2), element=element)
    return replace(scene, masks=replace(scene.masks, boxes=((0, 0, right, CAMERA.height - 1),)))


@pytest.mark.parametrize('element', list(Element))
def test_a_hidden_region_is_refused(depth: np.ndarray, element: Element) -> None:
    scene = _with_tip_masked(depth, element)
    message = (
        "'(part_.)' is fitted, and no pixel shows that region.* fit only youngs_modulus.part_"
    )
    with pytest.raises(InputError, match=message):
        calibrate(scene, [observation(depth)], _QUICK)


def test_a_hidden_region_that_is_not_fitted_is_no_matter(depth: np.ndarray) -> None:
    scene = _with_tip_masked(depth, Element.LINEAR)
    with pytest.raises(InputError) as error:
        calibrate(scene, [observation(depth)], _QUICK)
    seen = str(error.value).rpartition('youngs_modulus.')[2]
    result = calibrate(
        replace(scene, fit=(f'youngs_modulus.{seen}',)), [observation(depth)], _QUICK
    )
    assert np.isfinite(result.gap_end.median)
