# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How something is, in one sentence and a few figures."""

from dataclasses import dataclass, field
from enum import IntEnum


class Level(IntEnum):
    """How bad it is; the numbers are those of diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2


@dataclass(frozen=True)
class Health:
    """One line of a diagnosis.

    Attributes:
        level: how bad it is.
        message: one sentence.
        values: figures by name, with their units in the name.
    """

    level: Level
    message: str
    values: dict[str, str] = field(default_factory=dict)
