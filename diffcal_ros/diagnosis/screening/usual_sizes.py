# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How many times as large as usual an effect is: its amplitudes' sizes have a heavy tail.

A usual size says how likely an effect is, and not how large this one is. Taken for a standard
deviation it costs half the square of how many there are: the sail of a fin that swings, of seventy
usual areas, over 2,000 in log evidence, more than data give back. So the size of an effect is one
more unknown, with a half Cauchy prior about the usual one (Gelman, Bayesian Analysis 1, 2006), and
the likeliest is taken, as for the forms of effects (`form_sizes`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from diffcal_ros.diagnosis.screening.candidates import Candidate
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Usual sizes that are tried: less than one is no less likely than one.
SIZES = np.array([1.0, 3.0, 10.0, 30.0, 100.0])


def likeliest_size(amounts: FloatArray) -> float:
    """Return the likeliest size of an effect, in usual ones.

    Each amplitude is normal about zero and of that size; the size is half Cauchy, and looked for
    among steps of its logarithm, which is as if that were uniform between them.

    Args:
        amounts: its amplitudes in usual sizes, shape (a,).
    """
    square, count = float(np.sum(np.square(amounts))), len(amounts)
    believed = np.log(SIZES) - np.log1p(SIZES**2)
    levels = believed - 0.5 * square / SIZES**2 - count * np.log(SIZES)
    return float(SIZES[int(np.argmax(levels))])


def sized(candidate: Candidate, values: Mapping[str, float]) -> Candidate:
    """Return an effect with the size that is likeliest for its amplitudes.

    Args:
        candidate: the effect.
        values: of parameters, SI units by name; amplitudes without one are zero.
    """
    if not candidate.effect.has_tangent:
        return candidate  # Its amplitudes are places.
    amounts = [
        values.get(name, 0.0) / part.usual_size
        for name, part in zip(candidate.names, candidate.parts, strict=True)
        if part.has_prior
    ]
    return replace(candidate, size=likeliest_size(np.array(amounts)))


def all_sized(added: Sequence[Candidate], values: Mapping[str, float]) -> tuple[Candidate, ...]:
    """Return effects with the sizes that are likeliest for their amplitudes; see `sized`."""
    return tuple(sized(candidate, values) for candidate in added)
