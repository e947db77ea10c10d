# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A map of spots on a surface: its cells, its settings, how it is read and said."""

from diffcal_ros.diagnosis.verdict.verdict import NamedEffect
from diffcal_ros.effects import spots, surface_parts
from diffcal_ros.effects.registry import EFFECTS
from diffcal_ros.effects.spots import cells_of, ROUND, ROWS, spot_settings, Spots, spots_of
from diffcal_ros.errors import InputError
from diffcal_ros.report.tables.verdict_text import effect_words
from diffcal_ros.scene.load import load_scene
import numpy as np
import pytest


def _drawn(random, share=0.3):
    return random.random((ROWS, ROUND)) < share


def test_settings_of_a_map_are_that_map(random):
    cells = _drawn(random)
    np.testing.assert_array_equal(spots_of(spot_settings(cells)).cells, cells)
    # The most that a number may hold is held exactly.
    whole = np.ones((ROWS, ROUND), dtype=bool)
    assert set(spot_settings(whole).values()) == {spots.LARGEST}
    assert spots_of(spot_settings(whole)).cells.all()


def test_rows_without_spots_are_not_stated():
    cells = np.zeros((ROWS, ROUND), dtype=bool)
    cells[2, ROUND // 2 + 1] = True
    assert spot_settings(cells) == {'spots_2_3': 2.0}
    assert spots_of({'at': 0.5, 'spots_2_3': 0.0}) is None


def test_cells_follow_each_other_around_the_body():
    turn = np.linspace(0.0, 2.0 * np.pi, 4000, endpoint=False) + 1e-4
    square = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    square /= np.abs(square).max(axis=1, keepdims=True)
    numbers = cells_of(np.column_stack([np.full(len(turn), 0.51), square]))
    assert set(numbers // ROUND) == {int(0.51 * ROWS)}
    steps = np.diff(numbers % ROUND)
    # From the middle of the first side on, with one step back to its beginning.
    assert set(steps) == {0, 1, 1 - ROUND}
    assert len(set(numbers)) == ROUND
    # All cells of a side are alike in width, on the side.
    own = np.abs(square[:, 0]) == 1.0
    across = np.abs(np.diff(np.sort(square[own & (square[:, 0] > 0.0), 1])))
    assert across.max() < 2.0 / spots.OF_SIDE


def test_cells_go_along_the_body_to_its_very_ends():
    along = np.array([0.0, 0.5, 0.999, 1.0])
    places = np.column_stack([along, np.ones(4), np.zeros(4)])
    assert (cells_of(places) // ROUND).tolist() == [0, ROWS // 2, ROWS - 1, ROWS - 1]
    # What is on no side, as the middle of the tip, is in one of its cells.
    assert cells_of(np.array([1.0, 0.0, 0.0])) // ROUND == ROWS - 1


def test_spots_hold_what_is_in_their_cells(random):
    cells = _drawn(random)
    places = random.uniform((0.0, -1.0, -1.0), 1.0, size=(500, 3))
    (part,) = surface_parts.parts_of({'at': 0.3, **spot_settings(cells)})
    assert isinstance(part, Spots)
    np.testing.assert_array_equal(part.holds(places), cells.ravel()[cells_of(places)])
    np.testing.assert_array_equal(part.holds(places, (0.1, 0.1)), part.holds(places))
    assert (part.borders, part.limits_across) == ((), [[], []])


def test_a_scene_states_spots(write_scene, random):
    stated = {'bias': 0.004, **spot_settings(_drawn(random))}
    own = load_scene(write_scene({'effects': {'depth_bias_by_region': stated}})).effects
    # What is not stated is not repeated.
    assert own['depth_bias_by_region'] == {**stated, 'at': 0.5}


@pytest.mark.parametrize(
    'wrong', [{'spots_1_1': 2.0**48}, {'spots_1_1': -1.0}, {'spots_3_1': 1.0}]
)
def test_what_is_no_part_of_a_map_is_refused(write_scene, wrong):
    with pytest.raises(InputError, match=next(iter(wrong))):
        load_scene(write_scene({'effects': {'depth_bias_by_region': wrong}}))


def test_who_misspells_a_key_is_not_told_of_all_numbers_of_a_map(write_scene):
    with pytest.raises(InputError, match='did you mean `until`') as told:
        load_scene(write_scene({'effects': {'depth_bias_by_region': {'untill': 0.5}}}))
    assert 'spots' not in str(told.value)


def test_words_say_from_where_to_where_there_are_spots():
    cells = np.zeros((ROWS, ROUND), dtype=bool)
    cells[16, 3] = cells[47, 60] = True
    settings = spot_settings(cells)
    assert surface_parts.in_words(settings) == 'spots between 0.25 and 0.75 of the length'
    effect = EFFECTS['depth_bias_by_region']
    named = NamedEffect(
        identifier=effect.identifier,
        group=effect.group,
        amplitude={'bias': 4.1},
        std_error={'bias': 0.2},
        unit={'bias': 'mm'},
        setting=settings,
        frame={},
        confidence=0.8,
        sentence=effect.sentence,
        outside_twins=(),
    )
    words = effect_words(named)
    assert words.endswith(' on spots between 0.25 and 0.75 of the length')
