# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The motion of an observation: which held parts let go, when, and what is used of it."""

from collections.abc import Sequence

from diffcal_ros.scene.model import HeldPart, MotionSetup, QUASI_STATIC, SEMI_IMPLICIT
from diffcal_ros.scene.reading.problems import listed, suggestion
from diffcal_ros.scene.reading.quantities import quantity_shape, read_quantity, RELEASE_TIME
from diffcal_ros.scene.reading.section import Section
from diffcal_ros.scene.reading.shapes import Choice, Interval, Keys, ListOf, Number, Text, Whole
from diffcal_ros.scene.sections.held_parts import check_hold
from diffcal_ros.tet_mesh import TetMesh

INTEGRATORS = ('implicit', SEMI_IMPLICIT, QUASI_STATIC)
_STEPS = Interval(1e-6, 0.02)
_TOLERANCES = Interval(1e-8, 1e-3)
_DURATIONS = Interval(0.01, 600.0)
_USUAL_FRAMES, _MOST_FRAMES = 60, 2000
_USUAL_HOLD_OUT = 5

MOTION_SHAPE = Keys(
    {
        'released': ListOf(Text(), 'held parts that let go, all at once', fewest=1),
        'at': quantity_shape(RELEASE_TIME, 'when they let go, in s after the first frame'),
        'integrator': Choice(INTEGRATORS, 'quasi_static: a load held for long, which may creep'),
        'time_step': Number("in s; default: the integrator's own", _STEPS),
        'tolerance': Number('what one implicit step may be off by, in m', _TOLERANCES),
        'duration': Number('use only so much of the recording, in s', _DURATIONS),
        'frames': Whole('compare at most so many; default 60', 2, _MOST_FRAMES),
        'hold_out': Whole('keep one frame in as many from the fit; default 5', 0, _MOST_FRAMES),
    },
    ('released', 'at'),
    'how the body moves: parts that hold it at rest let go',
)


def read_motion(
    section: Section, held: Sequence[HeldPart], mesh: TetMesh | None
) -> MotionSetup | None:
    """Read {released, at, ..}; None when a mistake was noted.

    Args:
        section: the motion.
        held: parts that hold in its observation.
        mesh: to tell whether those that stay hold it.
    """
    released = _released(section, held)
    release_time = read_quantity(section, 'at', RELEASE_TIME)
    integrator = section.choice('integrator', default=INTEGRATORS[0])
    time_step = _optional(section, 'time_step')
    tolerance = _tolerance(section, integrator)
    duration = _optional(section, 'duration')
    most_frames = _count(section, 'frames', _USUAL_FRAMES)
    hold_out = _count(section, 'hold_out', _USUAL_HOLD_OUT)
    section.refuse_unknown()
    if hold_out == 1:
        section.wrong('hold_out', 'every frame would be kept from the fit: give 0, or 2 and more')
    staying = [part for part in held if part.name not in released]
    if section.is_sound and mesh is not None and held:
        if staying:
            check_hold(section, mesh, staying)
        else:
            section.wrong('released', 'no part is left to hold the body: keep one that stays')
    if release_time is None or not section.is_sound:
        return None
    return MotionSetup(
        released=released,
        release_time=release_time,
        integrator=integrator,
        time_step=time_step,
        duration=duration,
        most_frames=most_frames,
        hold_out=hold_out,
        tolerance=tolerance,
    )


def _released(section: Section, held: Sequence[HeldPart]) -> tuple[str, ...]:
    """Return the names of the parts that let go."""
    needed = 'give a list of held parts that let go'
    if not section.required('released', needed):
        return ()
    value = section.raw('released')
    if not isinstance(value, list) or not value or not all(isinstance(v, str) for v in value):
        section.wrong('released', needed)
        return ()
    names = [part.name for part in held]
    for name in value:
        if held and name not in names:
            section.problems.add(
                section.at('released'),
                f'has {name!r}, no part held here{suggestion(name, names)} '
                f'(held: {listed(names)})',
            )
    return tuple(dict.fromkeys(value))


def _tolerance(section: Section, integrator: str) -> float | None:
    """Return what a step may be off by [m]."""
    tolerance = _optional(section, 'tolerance', unit='metres')
    if tolerance is not None and integrator != INTEGRATORS[0]:
        section.wrong('tolerance', f'only steps of `integrator: {INTEGRATORS[0]}` follow one')
    return tolerance


def _optional(section: Section, name: str, *, unit: str = 'seconds') -> float | None:
    if not section.has(name):
        return None
    return section.number(name, needed=f'give {unit}, {section.allowed(name)}')


def _count(section: Section, name: str, usual: int) -> int:
    return section.integer(name) if section.has(name) else usual
