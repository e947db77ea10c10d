# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is left out of a view: boxes of the image, what the recording hides, the clamp."""

from dataclasses import replace

from diffcal_ros.calibration.observations.pixel_masks import make_view_mask, pixels_left_out
from diffcal_ros.depth.tracer import DepthTracer
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.scene.model import Masks
import numpy as np
import pytest
from support.beams import beam_mesh, held_end
from support.scenes import CAMERA, observation

SEEN = observation(np.full((CAMERA.height, CAMERA.width), 0.3))


def test_boxes_hold_their_corners_and_end_at_the_image() -> None:
    boxes = ((10, 20, 12, 21), (-5, 235, 2, 900))
    left_out = pixels_left_out(SEEN, Masks(boxes=boxes))
    expected = np.zeros((240, 320), dtype=bool)
    expected[20:22, 10:13] = True
    expected[235:240, 0:3] = True
    np.testing.assert_array_equal(left_out, expected)


def test_what_the_recording_leaves_out_is_added() -> None:
    hidden = np.zeros((240, 320), dtype=bool)
    hidden[100, 50] = True
    left_out = pixels_left_out(replace(SEEN, left_out=hidden), Masks(boxes=((0, 0, 0, 0),)))
    assert np.argwhere(left_out).tolist() == [[0, 0], [100, 50]]
    assert not pixels_left_out(SEEN, Masks()).any()


@pytest.fixture(scope='module')
def body() -> StaticBody:
    mesh = beam_mesh((6, 2, 2))
    return StaticBody(mesh, Element.LINEAR, held_end(mesh))


def _hidden_reach(body: StaticBody, masks: Masks) -> tuple[float, int]:
    """How far from the clamp triangles are left out [m], and how many edges."""
    nodes = body.discretisation.rest_nodes
    tracer = DepthTracer(body.discretisation.surface_triangles, len(nodes), CAMERA)
    mask = make_view_mask(SEEN, body, tracer, masks)
    held = nodes[body.held_nodes][:, 0].mean()
    hidden = tracer.triangles[mask.triangles]
    reach = np.abs(nodes[hidden][..., 0] - held).max() if len(hidden) else 0.0
    return float(reach), int(mask.edges.sum())


def test_the_clamp_hides_what_touches_it_and_its_margin_more(body) -> None:
    cell = 0.12 / 6
    reach, edges = _hidden_reach(body, Masks())
    assert reach == pytest.approx(cell)
    further, more = _hidden_reach(body, Masks(held_margin=1.5 * cell))
    assert further == pytest.approx(2.0 * cell)
    assert more > edges > 0
    assert _hidden_reach(body, Masks(held=False, held_margin=1.0)) == (0.0, 0)
