# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The material yields slowly under a load that is held: one Prony pair, see `fem.creep`."""

from dataclasses import replace

from diffcal_ros.effects.effect import Component, Effect, Numbers
from diffcal_ros.effects.site import Site
from diffcal_ros.fem.statics.creep import Creep, CreepChange
from diffcal_ros.fem.statics.force_changes import Change


class MaterialCreep(Effect):
    """The share of all stresses that relaxes, and the time in which it does."""

    identifier = 'creep'
    group = 'material'
    components = (
        Component('share', '1', 0.0, 0.9, 0.1, '%', 100.0),
        Component('tau', 's', 0.0, 1e5, 10.0, 's', 1.0, has_prior=False),
    )
    sentence = 'the material yields slowly under a load that is held'
    settles = ('a load held for three times as long',)
    twins = ('added_mass', 'clamp_offset')
    # Where nothing relaxes, the time in which it does changes nothing; refits go on from the best.
    screened_at = (0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0)
    screened_name = 'tau'
    needs_motion = True
    needs_hold = True

    def creep(self, own: Numbers) -> Creep:
        """Return the pair."""
        return Creep(own.get('share', 0.0), own.get('tau', 0.0))

    def change(self, component: str, own: Numbers, site: Site) -> Change:
        """Return a change of the share or of the time."""
        change = CreepChange(share=1.0) if component == 'share' else CreepChange(time=1.0)
        return replace(change, creep=self.creep(own))

    def stand_ins(self, site: Site) -> tuple[Change, ...]:
        """Return a share that relaxes in each time that is screened."""
        return tuple(CreepChange(creep=Creep(0.0, time), share=1.0) for time in self.screened_at)
