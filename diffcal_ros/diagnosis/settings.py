# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What may be chosen about a diagnosis."""

from dataclasses import dataclass


@dataclass(frozen=True)
class DiagnosisSettings:
    """Choices of a diagnosis.

    Attributes:
        margin: a gap above the floors that is smaller does not matter [m].
        without: identifiers that are left out of the library.
        fit: names of the nominal parameters; None: as the scene says.
        jobs: processes that refit models at the same time, where that is worth it.
    """

    margin: float = 0.0005
    without: tuple[str, ...] = ()
    fit: tuple[str, ...] | None = None
    jobs: int = 1
