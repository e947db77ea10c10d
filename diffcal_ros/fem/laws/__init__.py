# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Energy laws: one file each, found by its name.

A law is linear in two constants of each tetrahedron and gives CONVERSION (how they follow from
Lame's parameters), TAKES_TURNING_STEPS (whether Newton steps should turn elements instead of
stretching them), and the Warp functions and struct that `element_kernels` asks for. Where its
stress has a pressure on the cofactor of F that grows by the second constant with det F, as near
nu = 0.5, PRESSES_BY_VOLUME = True saves Newton steps.
"""

from importlib import import_module
from pathlib import Path
from types import ModuleType

USUAL_LAW = 'stable_neo_hookean'


def law_names() -> tuple[str, ...]:
    """List the laws, the usual one first; none is imported."""
    found = sorted(file.stem for file in Path(__file__).parent.glob('[!_]*.py'))
    return (USUAL_LAW, *(name for name in found if name != USUAL_LAW))


def find_law(name: str) -> ModuleType:
    """Return the module of a law.

    Raises:
        ValueError: for a name that is no law.
    """
    if name not in law_names():
        raise ValueError(f'law is {name!r}: use one of {", ".join(law_names())}')
    return import_module(f'{__name__}.{name}')
