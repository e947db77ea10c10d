# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What named effects are in the course of a recording, frame by frame and in words."""

from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.screening.candidates import Candidate


def course_of(hypothesis: Hypothesis, candidate: Candidate) -> dict[str, list[float]]:
    """Return amplitudes in each frame, by component, in the unit that people use.

    Args:
        hypothesis: the model.
        candidate: of its effects.

    Returns:
        In the order of the times of the frames; empty where it is the same in all.
    """
    own = [one for one in hypothesis.freed if one.effect == candidate.identifier]
    knots = {one.amplitude for one in own if one.knot is not None}
    model, coordinates = hypothesis.evaluator.model, hypothesis.fit.coordinates
    frames = sorted(
        (one.time, one.setup_index) for one in model.observations if one.time is not None
    )
    found: dict[str, list[float]] = {}
    for name in candidate.components:
        if name not in knots:
            continue
        factor = candidate.effect.component(name).shown_factor
        found[name] = [
            factor * model.effects.amplitudes(coordinates, index, time)[candidate.identifier][name]
            for time, index in frames
        ]
    return found


def spread_over_time(hypothesis: Hypothesis) -> list[str]:
    """Say which effects are other ones in the course of the recording, and from where to where."""
    said = []
    for candidate in hypothesis.added:
        words = []
        for name, values in course_of(hypothesis, candidate).items():
            unit = candidate.effect.component(name).shown_unit
            words.append(f'{name} from {min(values):.2g} to {max(values):.2g} {unit}')
        if words:
            said.append(
                f'{candidate.identifier} is another one in the course of the recording: '
                f'{", ".join(words)}; no scene has that: mend what is filmed, and record again'
            )
    return said
