# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A scene under another energy law than its file says."""

import copy
from dataclasses import replace

from diffcal_ros.errors import SceneError
from diffcal_ros.fem.laws import law_names, USUAL_LAW
from diffcal_ros.material import LameConvention
from diffcal_ros.scene.model import Scene


def with_law(scene: Scene, name: str) -> Scene:
    """Return the scene under a law; copies of its file that are written later say so too.

    Raises:
        SceneError: for a name that is no law, or one that the scene's convention rules out.
    """
    if name not in law_names():
        raise SceneError(f'law is {name!r}: use one of {", ".join(law_names())}')
    if name != USUAL_LAW and scene.convention is LameConvention.PAPER:
        raise SceneError(
            f"the scene's lame_convention is paper, which is known of {USUAL_LAW} only: leave it "
            'out, or keep that law'
        )
    document = copy.deepcopy(scene.document)
    if document:
        document['law'] = {**(document.get('law') or {}), 'name': name}
    return replace(scene, law=name, document=document)
