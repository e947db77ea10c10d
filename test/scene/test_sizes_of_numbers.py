# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Numbers that no quantity has are refused where they stand, not where they overflow."""

from diffcal_ros.calibration.field.layout import FieldKind, tets_from_unknowns
from diffcal_ros.errors import InputError, SceneError
from diffcal_ros.scene.load import load_scene
import pytest

MODULUS = 'regions.body.youngs_modulus'


@pytest.mark.parametrize(
    ('changes', 'sentence'),
    [
        (
            {MODULUS: {'start': 6e4, 'prior': {'mean': 6e4, 'std': 1e-300}}},
            r'prior\.std is 1e-300: no quantity is so small; give the standard deviation',
        ),
        (
            {MODULUS: {'start': 6e4, 'prior': {'mean': 6e4, 'std': 1e-5}}},
            r'prior\.std is 1e-05: nothing is known to 1e-06 of itself: leave it out of `fit`',
        ),
        (
            {'camera': {'width': 640, 'height': 480, 'fx': 1e-6, 'fy': 460, 'cx': 1, 'cy': 1}},
            r'camera\.fx is 1e-06: no camera sees so wide an angle on 640 pixels',
        ),
        ({'masks.silhouette_band': 1000}, 'silhouette_band is 1000: give a number at least 0 and'),
        ({'rigid_offset.translation_std': 1e-300}, 'between 1e-9 and 1'),
        ({'gravity': [0, -1e300, 0]}, 'give the acceleration in m/s'),
        ({'placement.translation': [1e300, 0, 0]}, 'translation is'),
    ],
)
def test_the_key_is_named(write_scene, changes, sentence):
    with pytest.raises(SceneError, match=sentence):
        load_scene(write_scene(changes))


@pytest.mark.parametrize('spacing', [1e-9, 1e-300, 0.0, float('nan')])
def test_a_grid_has_a_number_of_cells(beam_mesh, spacing):
    with pytest.raises(InputError, match='the control grid has a spacing of'):
        tets_from_unknowns(beam_mesh, FieldKind(spacing))


def test_a_thousand_mistakes_are_not_all_listed(write_scene):
    boxes = [[number] for number in range(1000)]
    with pytest.raises(SceneError, match='1000 mistakes') as caught:
        load_scene(write_scene({'masks.boxes': boxes}))
    lines = str(caught.value).splitlines()
    assert len(lines) == 32
    assert lines[-1].strip() == 'and 970 more'


@pytest.mark.parametrize('name', ['a/b', '../../x', 'a\nb', 'x' * 81])
def test_names_of_observations_can_be_those_of_files(write_scene, name):
    with pytest.raises(
        SceneError, match=r'observations\[0\]\.name is .*: it becomes part of file'
    ):
        load_scene(write_scene({'observations': [{'name': name}]}))
