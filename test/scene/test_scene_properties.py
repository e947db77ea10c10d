# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whatever stands in a scene: it is read, or every mistake is named in sentences."""

from diffcal_ros.errors import InputError
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.model import Scene
import pytest
from support.properties import many
import yaml

hypothesis = pytest.importorskip('hypothesis', reason='hypothesis is not installed')
given = hypothesis.given
st = pytest.importorskip('hypothesis.strategies')

_MANY = many(80)
_LONGEST = 4000
_SECTIONS = (
    *('format', 'name', 'mesh', 'held', 'regions', 'gravity', 'placement', 'marker', 'fit'),
    *('camera', 'color_camera', 'pose', 'motion', 'sensor', 'masks', 'effects', 'cables'),
    *('fixture', 'observations', 'bag', 'law', 'rigid_offset', 'anything'),
)
_KEYS = ('start', 'min', 'max', 'file', 'unit', 'box', 'x', 'youngs_modulus', 'translation', '')
texts = st.text(max_size=8)
scalars = st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), texts)
values = st.recursive(
    scalars,
    lambda inner: st.one_of(
        st.lists(inner, max_size=4),
        st.dictionaries(st.one_of(st.sampled_from(_KEYS), texts), inner, max_size=4),
    ),
    max_leaves=8,
)


def tried(path):
    """Return the scene, and what was refused."""
    try:
        return load_scene(path), ''
    except InputError as error:
        return None, str(error)


@_MANY
@given(section=st.sampled_from(_SECTIONS), value=values)
@pytest.mark.slow
def test_any_value_of_any_section_is_read_or_refused(write_scene, section, value):
    path = write_scene()
    document = yaml.safe_load(path.read_text())
    document[section] = value
    path.write_text(yaml.safe_dump(document), encoding='utf-8')
    found, problem = tried(path)
    assert isinstance(found, Scene) or 'scene.yaml' in problem
    assert len(problem) < _LONGEST


@_MANY
@given(text=st.text(max_size=60))
def test_any_text_is_refused(tmp_path, text):
    path = tmp_path / 'scene.yaml'
    path.write_text(text, encoding='utf-8')
    with pytest.raises(InputError, match=r'scene\.yaml'):
        load_scene(path)
