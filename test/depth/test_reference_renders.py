# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The tracer against the authors' images, with their errors copied by name."""

from pathlib import Path

from diffcal_ros.depth.tracer import DepthTracer
from diffcal_ros.rigid_transform import apply
import numpy as np
import pytest
from support.authors_image import authors_image
from support.captures import load_case, reference, RENDERED_CASES

_INSIDE_MEDIAN = 0.02e-3
_OVERLAP = 0.995


def _their_image(data: Path, case: str) -> np.ndarray:
    """Render the authors' end state as they do."""
    scene, (observation,) = load_case(data, case, 'stored')
    final = reference(data, case, 'final_state')
    points = apply(observation.depth_from_world, final)
    return authors_image(points, scene.mesh.surface_triangles, observation.camera)


@pytest.mark.parametrize('case', RENDERED_CASES)
def test_images_agree(diffcal_data: Path, case: str) -> None:
    ours, theirs = (
        _their_image(diffcal_data, case),
        reference(diffcal_data, case, 'rendered_images'),
    )
    both, either = (ours > 0.0) & (theirs > 0.0), (ours > 0.0) | (theirs > 0.0)
    assert np.median(np.abs(ours - theirs)[both]) <= _INSIDE_MEDIAN
    assert both.sum() / either.sum() >= _OVERLAP


def test_loss_of_the_start_agrees(diffcal_data: Path) -> None:
    _, (observation,) = load_case(diffcal_data, 'h_e_c', 'stored')
    target = np.nan_to_num(observation.depth.astype(np.float64))
    loss = 1e3 * np.linalg.norm(_their_image(diffcal_data, 'h_e_c') - target)
    assert loss == pytest.approx(209_230.0, abs=10.0)


def test_without_their_errors_the_images_differ(diffcal_data: Path) -> None:
    scene, (observation,) = load_case(diffcal_data, 'h_e_c', 'stored')
    final = reference(diffcal_data, 'h_e_c', 'final_state')
    tracer = DepthTracer(scene.mesh.surface_triangles, len(final), observation.camera)
    depth = tracer.trace(apply(observation.depth_from_world, final)).full_depth()
    theirs = reference(diffcal_data, 'h_e_c', 'rendered_images')
    both = np.isfinite(depth) & (theirs > 0.0)
    assert np.median(np.abs(depth - theirs)[both]) > 2e-3
