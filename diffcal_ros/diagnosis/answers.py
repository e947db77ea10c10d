# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The words in which a diagnosis answers."""

from enum import Enum


class Verdict(str, Enum):
    """Whether simulation and measurement agree."""

    AGREE = 'agree'
    DISAGREE = 'disagree'
    BELOW_MARGIN = 'below_margin'
    CANNOT_TELL = 'cannot_tell'


class Evidence(str, Enum):
    """What a verdict rests on: a sensor floor that was measured, or one that was assumed."""

    CONFIRMED = 'confirmed'
    SUSPECTED = 'suspected'
