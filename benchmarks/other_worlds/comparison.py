# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What verdicts of one recording in several worlds have in common."""

from dataclasses import dataclass
from typing import Any

# Moduli that differ by less are the same figure [standard errors].
_SAME_MODULUS = 1.0


@dataclass(frozen=True)
class Answer:
    """What a verdict says, in figures that do not know the world.

    Attributes:
        verdict: in one word.
        names: of the effects.
        classes: that are told where there is no name.
        gap: held out, before and after [mm].
        modulus: Young's modulus and its standard error [Pa].
    """

    verdict: str
    names: frozenset[str]
    classes: tuple[str, ...]
    gap: tuple[float | None, float | None]
    modulus: tuple[float, float]

    def as_dict(self) -> dict[str, Any]:
        """Return what a table holds of it."""
        return {
            'verdict': self.verdict,
            'names': sorted(self.names),
            'classes': list(self.classes),
            'gap_mm': list(self.gap),
            'youngs_modulus': list(self.modulus),
        }


def answer_of(verdict: dict[str, Any]) -> Answer:
    """Read what a verdict.json holds."""
    parameters = verdict['parameters']
    modulus = (parameters['after'] or parameters['before'])['youngs_modulus']
    return Answer(
        verdict=verdict['verdict'],
        names=frozenset(effect['identifier'] for effect in verdict['effects']),
        classes=tuple(verdict['unknown_classes']),
        gap=(verdict['gap_mm']['nominal'], verdict['gap_mm']['added']),
        modulus=(modulus['value'], modulus['std_error'] or 0.0),
    )


def compared(here: Answer, there: Answer, factor: float) -> dict[str, Any]:
    """Hold the answer in another world against the one in this.

    Args:
        here: the answer as it is.
        there: in the other world.
        factor: by which that world's modulus is this one's.

    Returns:
        Whether verdict and names are the same; whether a name is given there that contradicts:
        another one than here, or one where there was none; by how many of their standard errors
        the moduli differ.
    """
    value, std_error = (part / factor for part in there.modulus)
    spread = max(std_error, here.modulus[1], 1e-9 * abs(here.modulus[0]))
    off = abs(value - here.modulus[0]) / spread
    return {
        'is_same': there.verdict == here.verdict and there.names == here.names,
        'contradicts': bool(there.names - here.names),
        'lost_name': bool(here.names - there.names),
        'modulus_off': off,
        'same_modulus': off < _SAME_MODULUS,
    }
