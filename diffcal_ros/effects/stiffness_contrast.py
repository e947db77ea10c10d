# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One part of the body is stiffer than another: a step, or a gradient along it."""

from diffcal_ros.effects import bands
from diffcal_ros.effects.along_body import at_share, hat
from diffcal_ros.effects.effect import Component, Effect, FloatArray, Numbers
from diffcal_ros.effects.site import Tets
import numpy as np

# Places along the body between which the modulus may be another one.
_ALONG = np.linspace(0.0, 1.0, 9)


class StiffnessContrast(Effect):
    """What is added to the logarithm of Young's modulus, from one end to the other."""

    identifier = 'stiffness_contrast'
    group = 'material'
    components = tuple(
        Component(name, '1', -4.0, 4.0, 1.0, 'log E', 1.0) for name in ('split', 'along')
    )
    sentence = 'one part of the body is stiffer than another'
    settles = ('a twist besides the bend',)
    twins = ('added_mass', 'compliant_clamp')
    settings = bands.SETTINGS
    has_boundary = True
    variants = (('split',), ('along',))
    forms = tuple(
        Component(f'part_{place + 1}', '1', -4.0, 4.0, 1.0, 'log E', 1.0, where=at_share(at))
        for place, at in enumerate(_ALONG)
    )
    form = 'the modulus is another one along the body'

    def log_modulus_mode(self, component: str, own: Numbers, tets: Tets) -> FloatArray:
        """Return a step at the boundary, a gradient, or more of it at one place, shape (T,)."""
        if component == 'along':
            return tets.fraction - 0.5
        head, _, place = component.partition('_')
        if head == 'part':
            return hat(tets.fraction, _ALONG, int(place))
        return np.where(tets.second(own), 0.5, -0.5)
