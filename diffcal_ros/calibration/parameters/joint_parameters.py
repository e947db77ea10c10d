# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The parameters of several bodies that are fitted together, some of them in common."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from diffcal_ros.calibration.parameters.parameters import Parameter, ParameterSet
from diffcal_ros.errors import InputError
from diffcal_ros.least_squares.normal_equations import Prior
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Shared = Mapping[str, Mapping[str, str]]


@dataclass(frozen=True)
class JointParameters(ParameterSet):
    """The parameters of all members; those in common stand there once, and first.

    Attributes:
        members: parameters of each member.
        indices: where each of a member's coordinates stands among all, shape (k,) each.
    """

    members: tuple[ParameterSet, ...] = ()
    indices: tuple[IntArray, ...] = ()

    def prior(self, leeway: float = 1.0) -> Prior:
        """Return what is known of the coordinates of all members together."""
        means, precision = np.zeros(len(self)), np.zeros((len(self), len(self)))
        for member, indices in zip(self.members, self.indices, strict=True):
            mean, own = member.prior(leeway)
            means[indices] += mean
            precision[np.ix_(indices, indices)] += own
        return Prior(means, precision)


def joint_parameters(members: Mapping[str, ParameterSet], shared: Shared) -> JointParameters:
    """Lay out the parameters of several members.

    Args:
        members: their parameters by name.
        shared: for the name of each parameter in common, what it is called in which member.

    Raises:
        InputError: when a member lacks such a parameter, or gives it a prior of its own.
    """
    owners = {
        (member, own): name for name, names in shared.items() for member, own in names.items()
    }
    for member, own in owners:
        if member not in members or own not in members[member].names:
            known = {name: list(parameters.names) for name, parameters in members.items()}
            raise InputError(f'{member} fits no {own!r} to be shared: members fit {known}')
    joint: dict[str, Parameter] = {}
    for name, names in shared.items():
        member, own = next(iter(names.items()))
        index = members[member].names.index(own)
        joint[name] = replace(members[member].parameters[index], name=name)
    labels: list[list[str]] = []
    for member, parameters in members.items():
        labels.append([])
        for parameter in parameters:
            label = owners.get((member, parameter.name))
            if label is None:
                label = f'{parameter.name} ({member})'
                joint[label] = replace(parameter, name=label)
            elif parameter.quantity.prior_mean is not None:
                raise InputError(
                    f'{member} has a prior on {parameter.name}, which is shared: it would count '
                    'once for each member; take it out'
                )
            labels[-1].append(label)
    order = {label: index for index, label in enumerate(joint)}
    return JointParameters(
        tuple(joint.values()),
        members=tuple(members.values()),
        indices=tuple(np.array([order[label] for label in own]) for own in labels),
    )
