# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The depth camera reads one of two materials too far or too near."""

from collections.abc import Sequence

from diffcal_ros.effects import bands, spots, surface_parts
from diffcal_ros.effects.along_body import at_share, hat
from diffcal_ros.effects.effect import Component, Effect, FloatArray, Numbers
from diffcal_ros.effects.site import FitsSeen, SeenPixels, Site
import numpy as np

# Places along the body between which the error may be another one, and how it may be another one
# across the body there: all of it, evenly from side to side, on one side, or by which way the
# surface faces, as what the sun has bleached or dust has settled on.
_ALONG = np.linspace(0.0, 1.0, 13)
_WAYS = {
    'all': '',
    **{axis: f', rising by {axis}' for axis in 'ab'},
    **{f'side_{axis}': f', on the side of {axis}' for axis in 'ab'},
    **{f'facing_{axis}': f', where it faces {axis}' for axis in 'ab'},
}
# What a further part of the surface is read by besides.
_PART = 'part_'
# So steep is the border of a side, in units of the half width.
_STEEP = 3.0


def _of_form(name: str, where: str) -> Component:
    return Component(name, 'm', -0.05, 0.05, 0.005, 'mm', 1e3, where=where)


_FORMS = (
    *(
        _of_form(f'{way}_{place + 1}', f'{at_share(at)}{words}')
        for place, at in enumerate(_ALONG)
        for way, words in _WAYS.items()
    ),
    *(
        _of_form(f'{_PART}{number}', f'in part {number}')
        for number in range(2, bands.MOST_BANDS + 1)
    ),
)

# Steps of depth that lead to the same fit [m].
_SAME_STEP = 0.003
# Tangents follow one that is smaller [m].
_LEAST_STEP = 0.001
# Less is no part of a view [px].
_LEAST_PIXELS = 50
# What had followed the larger part of the body; the step is between the two.
_FOLLOWS = 'rigid_offset.z'


class DepthBiasByRegion(Effect):
    """A step of depth on a continuous surface, independent of the load."""

    identifier = 'depth_bias_by_region'
    group = 'sensor'
    # How deep a camera looks into a material nobody knows beforehand: centimetres in silicone.
    components = (Component('bias', 'm', -0.05, 0.05, 0.005, 'mm', 1e3, nominal_std=0.05),)
    sentence = 'the depth camera reads one of the materials too far or too near'
    settles = ('both materials flat on one plane',)
    twins = ('camera_offset', 'clamp_offset')
    settings = {**bands.SETTINGS, **surface_parts.SETTINGS}  # noqa: RUF012
    map_pattern = spots.PATTERN
    has_boundary = True
    form = 'the error is another one along and across the body'
    forms = _FORMS

    def depth_error_mode(self, component: str, seen: SeenPixels) -> FloatArray:
        """Return where it reads too far."""
        if component == 'bias':
            if seen.parts is None or seen.times is None:
                return seen.is_second.astype(np.float64)
            return np.asarray(seen.parts @ seen.times)
        if component.startswith(_PART):
            number = int(component.removeprefix(_PART))
            if seen.parts is None or seen.parts.shape[-1] < number:
                return np.zeros_like(seen.depth)
            return seen.parts[..., number - 1].astype(np.float64)
        if seen.places is None or seen.sides is None:
            return np.zeros_like(seen.depth)
        way, _, place = component.rpartition('_')
        error = hat(seen.places[..., 0], _ALONG, int(place))
        if way == 'all':
            return error
        if 'facing' in way:
            return error * seen.sides[..., 'ab'.index(way[-1])]
        across = seen.places[..., 1 + 'ab'.index(way[-1])]
        return error * (np.clip(_STEEP * across, -1.0, 1.0) if 'side' in way else across)

    def part_forms(self, count: int) -> tuple[str, ...]:
        """One of each part after the first."""
        return tuple(f'{_PART}{number}' for number in range(2, count + 1))

    def limits_of(self, setting: str) -> tuple[float, float]:
        """Return what a setting may be."""
        return surface_parts.setting_limits(setting)

    def frame(self, own: Numbers, site: Site) -> dict[str, FloatArray]:
        """`a` and `b` are axes in the object's frame; they go along with a bent body."""
        return {'a': site.object_axes.at_root[1], 'b': site.object_axes.at_root[2]}

    def starts(self, seen: FitsSeen, screened: float | None) -> list[dict[str, float]]:
        """Propose the step between the materials: it may be beyond a robust fit's reach.

        Read at the nominal fit, and where that fit began: it may have turned the body, or bent it
        to a wrong stiffness, to follow the step.
        """
        name, found = self.amplitude_name('bias'), [dict[str, float]()]
        for values, before in ((seen.end, {}), (seen.begin, seen.begin)):
            step = self._step(seen.residuals(values))
            if step is None:
                continue
            height, first = step
            if abs(height) < _LEAST_STEP:
                continue
            if any(abs(height - other.get(name, np.inf)) < _SAME_STEP for other in found):
                continue
            start = {**before, name: height}
            if _FOLLOWS in values:
                start[_FOLLOWS] = values[_FOLLOWS] + first
            found.append(start)
        return found

    def _step(self, views: Sequence[SeenPixels]) -> tuple[float, float] | None:
        """Return the step's height and what the first material is off by [m]; None: not seen."""
        parts = [(v.depth[~v.is_second], v.depth[v.is_second]) for v in views]
        seen = [pair for pair in parts if min(map(len, pair)) > _LEAST_PIXELS]
        if not seen:
            return None
        firsts, seconds = (
            [float(np.median(part)) for part in own] for own in zip(*seen, strict=True)
        )
        heights = np.subtract(seconds, firsts)
        return float(np.median(heights)), float(np.median(firsts))
