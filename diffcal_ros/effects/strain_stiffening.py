# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The material stiffens when it is strained: a Yeoh term beside the elastic energy."""

from diffcal_ros.effects.effect import Component, Effect, Numbers
from diffcal_ros.effects.site import Site
from diffcal_ros.fem.terms.conditions import Conditions
from diffcal_ros.fem.terms.potential_terms import ShearRatio


class StrainStiffening(Effect):
    """Yeoh's second coefficient over the first, which is half the shear modulus."""

    identifier = 'strain_stiffening'
    group = 'material'
    components = (Component('ratio', '1', 0.0, 300.0, 30.0, 'C2/C1', 1.0),)
    sentence = 'the material stiffens when it is strained'
    settles = ('a second load that strains it less',)
    twins = ('stiffness_contrast',)
    # What it does levels off, so that a large one can hide where a small one would be seen.
    has_limit = False

    def conditions(self, own: Numbers, site: Site) -> Conditions:
        """Return the energy."""
        # Its kernels, and Warp with them, are not needed to read a scene.
        from diffcal_ros.fem.terms import strain_stiffening

        return Conditions(potentials=(ShearRatio(own['ratio'], strain_stiffening),))
