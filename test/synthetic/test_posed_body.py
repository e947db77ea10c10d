# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The true body: its finer mesh is the same solid, and it rests where its start values say."""

from dataclasses import replace

from diffcal_ros.errors import SceneError
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.scene.refinement import refined_scene
from diffcal_ros.scene.start_material import start_material
from diffcal_ros.synthetic.posed_body import pose_body
import numpy as np
import pytest
from support.scenes import beam_scene


def test_a_refined_scene_has_the_same_regions_and_held_parts():
    scene = beam_scene(region_count=3)
    fine = refined_scene(scene)
    assert fine.mesh.tet_count == 8 * scene.mesh.tet_count
    for coarse_region, fine_region in zip(scene.regions, fine.regions, strict=True):
        np.testing.assert_allclose(
            fine.mesh.volumes[fine_region.tets].sum(),
            scene.mesh.volumes[coarse_region.tets].sum(),
            rtol=1e-12,
        )
    (coarse,), (finer,) = scene.observations[0].held, fine.observations[0].held
    own, new = scene.mesh.rest_positions[coarse.vertices], fine.mesh.rest_positions[finer.vertices]
    np.testing.assert_allclose(new.min(axis=0), own.min(axis=0), atol=1e-12)
    np.testing.assert_allclose(new.max(axis=0), own.max(axis=0), atol=1e-12)
    # Every vertex of the fine mesh on the held face is held, and no other.
    on_face = fine.mesh.rest_positions[:, 0] <= own[:, 0].max() + 1e-9
    assert set(finer.vertices) == set(np.flatnonzero(on_face))


def test_the_material_is_that_of_the_start_values_region_by_region():
    scene = beam_scene(region_count=2)
    stiff = replace(
        scene.regions[1], youngs_modulus=replace(scene.regions[1].youngs_modulus, start=5e5)
    )
    material = start_material(replace(scene, regions=(scene.regions[0], stiff)))
    assert (material.youngs_modulus[stiff.tets] == 5e5).all()
    others = scene.regions[0].tets
    assert (material.youngs_modulus[others] == scene.regions[0].youngs_modulus.start).all()


def test_a_finer_body_sags_a_little_more_a_linear_one_much_less():
    """Finite elements are too stiff, linear tetrahedra by far."""
    scene = beam_scene((6, 2, 2))
    setup = scene.observations[0]
    coarse = pose_body(scene, setup).largest_displacement
    fine_scene = refined_scene(scene)
    fine = pose_body(fine_scene, fine_scene.observations[0]).largest_displacement
    linear = pose_body(replace(scene, element=Element.LINEAR), setup).largest_displacement
    assert coarse < fine < 1.05 * coarse
    assert linear < 0.8 * coarse


def test_outward_points_from_the_clamp_to_the_body():
    scene = beam_scene()
    body = pose_body(scene, scene.observations[0])
    held = body.positions[body.held_nodes]
    np.testing.assert_allclose(held, body.rest[body.held_nodes], atol=1e-12)
    assert body.outward @ (body.rest.mean(axis=0) - held.mean(axis=0)) > 0.0


@pytest.mark.slow
def test_a_body_that_finds_no_rest_is_bad_input():
    scene = beam_scene(modulus=1e3, gravity=np.array([0.0, -2000.0, 0.0]))
    with pytest.raises(SceneError, match=r'start values of .* cannot be simulated'):
        pose_body(scene, scene.observations[0])
