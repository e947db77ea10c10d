# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a diagnosis says: agree, disagree, below the margin or cannot tell, and why."""

from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from diffcal_ros.atomic_file import json_values, write_json_atomically
from diffcal_ros.diagnosis.answers import Evidence, Verdict
from diffcal_ros.diagnosis.verdict.time_course import TimeCourse


@dataclass(frozen=True)
class NamedEffect:
    """An effect that was found.

    Attributes:
        identifier: of the library.
        group: of it.
        amplitude: by component, in the unit of that.
        std_error: by component.
        unit: by component.
        setting: fixed numbers that go with it, such as a place along the body.
        form: what it is more in another form than the library's, SI units by `Effect.forms`.
        frame: points and axes that the amplitudes refer to, see `frames.frame_of`.
        confidence: probability that the name is right, 0 to 1.
        sentence: for a person.
        outside_twins: causes outside the library that look the same, in words.
        course: amplitudes in each frame of a motion, as `amplitude`, in the order of their times;
            empty where they are the same in all.
    """

    identifier: str
    group: str
    amplitude: dict[str, float]
    std_error: dict[str, float]
    unit: dict[str, str]
    setting: dict[str, float]
    frame: dict[str, list[float]]
    confidence: float
    sentence: str
    outside_twins: tuple[str, ...] = ()
    form: dict[str, float] = field(default_factory=dict)
    course: dict[str, list[float]] = field(default_factory=dict)


@dataclass(frozen=True)
class GapFigures:
    """Root mean square of the gap on the patches kept for the report [mm].

    Attributes:
        nominal: of the model as it was.
        added: with the effects found; as nominal where none was named.
        floor_sensor: what the sensor's noise alone would give.
        floor_numerics: what the mesh may add.
        median_nominal: median of the sizes, as nominal.
        median_added: with the effects.
    """

    nominal: float
    added: float
    floor_sensor: float
    floor_numerics: float
    median_nominal: float
    median_added: float


@dataclass(frozen=True)
class StandIn:
    """Smooth fields in the place of an effect that has no name; no cause.

    Attributes:
        group: class of the fields.
        frame: what they are fixed to, in words.
        size_mm: how far one of them moves the body, root mean square of its prior [mm].
        closes: share of the held-out gap above the floor that they close; NaN within the floor.
        predictions: by class, log density of each view given the others, above that of no field.
    """

    group: str
    frame: str
    size_mm: float
    closes: float
    predictions: dict[str, float]


@dataclass(frozen=True)
class Diagnosis:
    """A whole verdict; see `save_verdict` for the file.

    Attributes:
        verdict: in one word.
        evidence: confirmed when the sensor floor was measured from repeated frames.
        p_value: of the disagreement, under clean data.
        effects: those named; several only when both are needed.
        ambiguity_set: identifiers that explain the data as well.
        runner_up: the next best one, or None.
        unknown_class: class of an effect outside the library, or None.
        unknown_classes: the same with the other one that it may be of.
        stand_in: fields in place of an effect outside the library, where several views tell them.
        separating_recording: what to record to settle a doubt, or None.
        where: where the gap is largest, in words.
        when: how the gap of a motion goes, see `time_course.TimeCourse`; None at rest.
        gap_mm: on held-out patches.
        closure: share of the gap above the floor that the effects close; NaN without effects.
        parameters: before and after, by name: value, std_error, unit.
        times_detectable: expected amplitude over the smallest detectable one, by effect.
        limits: how large each effect may be without standing out, see `limits.upper_limits`.
        drawn: how far what hides may have drawn each parameter, as a share, by parameter and
            effect, see `limits.drawn_parameters`: as it is beside the named effects, or was
            before.
        largest_cosine: how alike another effect could look, by effect, 0 to 1.
        seconds: that the diagnosis took.
        notes: what else a person should know.
        details: scores, versions, hashes.
    """

    verdict: Verdict
    evidence: Evidence
    p_value: float
    effects: tuple[NamedEffect, ...]
    ambiguity_set: tuple[str, ...]
    runner_up: str | None
    unknown_class: str | None
    stand_in: StandIn | None
    separating_recording: str | None
    where: str
    gap_mm: GapFigures
    closure: float
    parameters: dict[str, dict[str, dict[str, float | str]]]
    times_detectable: dict[str, float]
    limits: dict[str, dict[str, float]]
    drawn: dict[str, dict[str, float]]
    largest_cosine: dict[str, float]
    seconds: float
    unknown_classes: tuple[str, ...] = ()
    when: TimeCourse | None = None
    notes: tuple[str, ...] = ()
    details: dict[str, Any] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """Return what verdict.json holds; numbers that are not finite become null."""
        words = {'verdict': self.verdict.value, 'evidence': self.evidence.value}
        plain: dict[str, Any] = json_values({**asdict(self), **words})
        return plain


def save_verdict(diagnosis: Diagnosis, path: Path) -> None:
    """Write verdict.json, completely or not at all.

    Raises:
        InputError: when the file cannot be written.
    """
    write_json_atomically(path, diagnosis.as_dict())
