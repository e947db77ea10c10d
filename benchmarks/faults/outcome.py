# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What came of one case of the campaign."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Outcome:
    """One case.

    Attributes:
        kind: of fault, such as content.
        name: for messages, and to run it again.
        outcome: in a word or two.
        detail: in words.
    """

    kind: str
    name: str
    outcome: str
    detail: str = ''
