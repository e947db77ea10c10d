# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which parts of the surface of a body of one region a depth camera reads otherwise.

Bands, strips, faces, stickers: each part is one stretch of `bands`, and may be limited across the
body by settings of its own, shares of the width from one side to the other by the body's axes
across it: `a_from` and `a_until`, `b_from` and `b_until`, with `_2` and so on of the next ones.
`slant_a` and `slant_b` say by how much farther along the first one's borders are at the side of
each axis than amid the width, as on what was dipped aslant.
`times_2` says how many times as much a further part adds to what is read as the first; where two
overlap both do. Where a map of `spots` is stated, that is the part, and there is no other.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from diffcal_ros.effects import bands, spots
from diffcal_ros.effects.spots import Spots
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

# What is farther out than so many half widths is a face alone, whose limits are its edges.
FACE = 0.95
# Of a further part: the first one is read once as far.
_MOST_TIMES = 5.0
# A border goes no more aslant than this from the middle of the width to its side.
_MOST_SLANT = 1.0
_SLANTS = ('slant_a', 'slant_b')
_ACROSS = {'a_from': 0.0, 'a_until': 1.0, 'b_from': 0.0, 'b_until': 1.0}
_NUMBERS = range(1, bands.MOST_BANDS + 1)


def _named(name: str, number: int) -> str:
    return f'{name}_{number}' if number > 1 else name


_TIMES = {_named('times', number): 1.0 for number in _NUMBERS[1:]}
SETTINGS = {
    **{_named(name, number): usual for number in _NUMBERS for name, usual in _ACROSS.items()},
    **_TIMES,
    **dict.fromkeys(_SLANTS, 0.0),
    **spots.SETTINGS,
}


def setting_limits(name: str) -> tuple[float, float]:
    """Return what a setting may be."""
    if name in spots.SETTINGS:
        return (0.0, spots.LARGEST)
    if name in _SLANTS:
        return (-_MOST_SLANT, _MOST_SLANT)
    return (-_MOST_TIMES, _MOST_TIMES) if name in _TIMES else (0.0, 1.0)


def no_limits() -> FloatArray:
    """Return limits of what has all the width, see `SurfacePart`, shape (2, 2)."""
    return np.array([[-np.inf, np.inf]] * 2)


@dataclass(frozen=True)
class SurfacePart:
    """A part of the surface.

    Attributes:
        begin: where it begins along the body, as a share of the free length.
        end: where it ends; 1 and more: at the tip.
        limits: from where to where it is across both axes, in half widths from the middle, shape
            (2, 2); infinite: there is no limit.
        times: how many times as much it adds to what is read as the first part.
        slants: by how much farther along its beginning and end are at the side of each axis
            across than amid the width.
    """

    begin: float
    end: float
    limits: FloatArray = field(default_factory=no_limits)
    times: float = 1.0
    slants: tuple[float, float] = (0.0, 0.0)

    def holds(self, places: FloatArray, margin: tuple[float, float] = (0.0, 0.0)) -> BoolArray:
        """Tell which points are in it, shape (...,).

        Args:
            places: see `BodyAxes.on_surface`, shape (..., 3).
            margin: by how much more it reaches, along and across, see there.
        """
        along, across = self.along(places), places[..., 1:]
        # At clamp and tip it has no border.
        begin = self.begin - margin[0] if self.begin > 0.0 else 0.0
        end = self.end + margin[0] if self.end < 1.0 else np.inf
        is_along = (along > begin) & (along <= end)
        moved = margin[1] * (np.abs(self.limits) < FACE)
        low, high = (self.limits + moved * (-1.0, 1.0)).T
        return np.asarray(is_along & ((across > low) & (across <= high)).all(axis=-1))

    def along(self, places: FloatArray) -> FloatArray:
        """Return how far along points are by borders that go as this part's, shape (...,).

        Args:
            places: see `BodyAxes.on_surface`, shape (..., 3).
        """
        if not any(self.slants):
            return places[..., 0]
        return along_aslant(places, np.array([self.slants]))[..., 0]

    @property
    def borders(self) -> tuple[float, ...]:
        """Where it begins and ends along the body, but for clamp and tip."""
        return tuple(end for end in (self.begin, self.end) if 0.0 < end < 1.0)

    @property
    def limits_across(self) -> list[list[float]]:
        """Limits across each axis that are on the faces there, and not at their edges."""
        return [[limit for limit in way if abs(limit) < FACE] for way in self.limits.tolist()]


def along_aslant(places: FloatArray, slants: FloatArray) -> FloatArray:
    """Return how far along points are by borders that go aslant, shape (..., s).

    Args:
        places: see `BodyAxes.on_surface`, shape (..., 3).
        slants: see `SurfacePart`, shape (s, 2).
    """
    return np.asarray(places[..., :1] - np.clip(places[..., 1:], -1.0, 1.0) @ slants.T)


SeenPart = SurfacePart | Spots


def parts_of(settings: Mapping[str, float]) -> tuple[SeenPart, ...]:
    """Return the parts that settings state, those that begin at the tip left out."""
    found = spots.spots_of(settings)
    return _stretches_of(settings) if found is None else (found,)


def held_by(parts: Sequence[SeenPart], places: FloatArray) -> FloatArray:
    """Return which parts hold points, shape (M, p).

    Args:
        parts: of the surface.
        places: see `BodyAxes.on_surface`, shape (M, 3).
    """
    held = [part.holds(places) for part in parts]
    return np.array(held, dtype=np.float64).reshape(len(parts), len(places)).T


def _stretches_of(settings: Mapping[str, float]) -> tuple[SurfacePart, ...]:
    stated = {**bands.SETTINGS, **SETTINGS, **settings}
    found = []
    for number in _NUMBERS:
        ends = sorted(stated[_named(name, number)] for name in ('at', 'until'))
        if ends[0] >= 1.0:
            continue
        shares = [stated[_named(name, number)] for name in _ACROSS]
        limits = 2.0 * np.reshape(shares, (2, 2)) - 1.0
        # What is at a side is beyond no limit there.
        limits = np.where(limits <= -1.0, -np.inf, np.where(limits >= 1.0, np.inf, limits))
        times = stated.get(_named('times', number), 1.0)
        slants = (stated[_SLANTS[0]], stated[_SLANTS[1]]) if number == 1 else (0.0, 0.0)
        found.append(SurfacePart(ends[0], ends[1], limits, times, slants))
    return tuple(found)


def part_settings(parts: Sequence[SurfacePart]) -> dict[str, float]:
    """Return the settings of parts; of what they leave as usual none but where they begin.

    Raises:
        ValueError: of more parts than there are settings, or where a further one goes aslant.
    """
    if len(parts) > bands.MOST_BANDS:
        raise ValueError(f'{len(parts)} parts: at most {bands.MOST_BANDS} can be stated')
    if any(any(part.slants) for part in parts[1:]):
        raise ValueError('a further part goes aslant: of the first alone that can be stated')
    found = dict[str, float]()
    for number, part in enumerate(parts, 1):
        shares = np.clip(0.5 * (part.limits + 1.0), 0.0, 1.0).round(4).ravel().tolist()
        own = dict(zip(_ACROSS, shares, strict=True))
        own |= {'until': round(min(part.end, 1.0), 4), 'times': round(part.times, 4)}
        usual = {**_ACROSS, 'until': 1.0, 'times': 1.0}
        found[_named('at', number)] = round(part.begin, 4)
        found |= {_named(k, number): v for k, v in own.items() if v != usual[k]}
    slants = parts[0].slants if parts else (0.0, 0.0)
    return found | {k: round(v, 4) for k, v in zip(_SLANTS, slants, strict=True) if v}


def without_unused(numbers: Mapping[str, float]) -> dict[str, float]:
    """Return an effect's numbers without settings that leave all as it is."""
    return {k: v for k, v in numbers.items() if k not in SETTINGS or v != SETTINGS[k]}


def in_words(settings: Mapping[str, float]) -> str:
    """Say which parts those are, such as `0.3 to the tip, across b 0 to 0.6 of the width`."""
    spotted = spots.spots_of(settings)
    if spotted is not None:
        begin, end = spotted.reach
        return f'spots between {begin:.2g} and {end:.2g} of the length'
    parts = _stretches_of(settings)
    if not any(_is_limited(part) for part in parts):
        return f'{bands.in_words(settings)} of the length'
    return ' and '.join(_words_of(part) for part in parts)


def _is_limited(part: SurfacePart) -> bool:
    return part.times != 1.0 or any(part.slants) or bool(np.isfinite(part.limits).any())


def _words_of(part: SurfacePart) -> str:
    end = f'{part.end:g}' if part.end < 1.0 else 'the tip'
    words = f'{part.begin:g} to {end} of the length'
    across = []
    for axis, (low, high) in zip('ab', np.clip(0.5 * (part.limits + 1.0), 0.0, 1.0), strict=True):
        if (low, high) != (0.0, 1.0):
            across.append(f'{axis} {round(float(low), 4):g} to {round(float(high), 4):g}')
    if across:
        words = f'{words}, across {", ".join(across)} of the width'
    aslant = [f'{way:+.2g} at {axis}' for axis, way in zip('ab', part.slants, strict=True) if way]
    if aslant:
        words = f'{words}, aslant ({", ".join(aslant)})'
    return f'{words} ({part.times:g} times as much)' if part.times != 1.0 else words
