# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Something hangs on the body at a place along it, and swings with it."""

from diffcal_ros.effects.along_body import at_share
from diffcal_ros.effects.effect import Component, Effect, Numbers
from diffcal_ros.effects.site import Site
from diffcal_ros.fem.statics.force_changes import Change
from diffcal_ros.fem.terms.conditions import Conditions

# A mass is spread over this share of the body's length; more in the screening, where one of
# several places must stand for what is between them.
_WIDTH, _SCREENED_WIDTH = 0.03, 0.05
# Places where there may be more of it or less, and over what share of the length each is spread.
_PLACES, _SPREAD = 8, 0.1


class AddedMass(Effect):
    """A mass on the body."""

    identifier = 'added_mass'
    group = 'load'
    components = (Component('mass', 'kg', 0.0, 0.5, 0.010, 'g', 1e3, by_mass=1),)
    sentence = 'something hangs on the body'
    settles = ('the weight of the body', 'a pose with the body upside down')
    twins = ('stiffness_contrast',)
    # It slides, dries or is taken off.
    most_by_pose = 1.0
    has_common_part = True
    settings = {'at': 1.0}  # noqa: RUF012  Share of the free length.
    # One between two places still looks like one of them, and less like a contrast of stiffness.
    screened_at = (0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0)
    forms = tuple(
        Component(
            f'mass_{place}',
            'kg',
            -0.5,
            0.5,
            0.010,
            'g',
            1e3,
            where=at_share(place / _PLACES),
            by_mass=1,
        )
        for place in range(1, _PLACES + 1)
    )
    form = 'it is spread over the body, or hangs at several places'

    def conditions(self, own: Numbers, site: Site) -> Conditions:
        """Return the mass at the nodes around its place, and what more there is elsewhere."""
        masses = own['mass'] * site.weights_at(own['at'], _WIDTH)
        for place, part in enumerate(self.forms):
            more = own.get(part.name, 0.0)
            if more:
                masses = masses + more * site.weights_at((place + 1) / _PLACES, _SPREAD)
        return Conditions(added_masses=masses)

    def amount(self, own: Numbers) -> float:
        """Return all that hangs on the body [kg]."""
        return own['mass'] + sum(own.get(part.name, 0.0) for part in self.forms)

    def stand_ins(self, site: Site) -> tuple[Change, ...]:
        """Return a mass at each place that is screened."""
        return tuple(
            Change(conditions=Conditions(added_masses=site.weights_at(at, _SCREENED_WIDTH)))
            for at in self.screened_at
        )
