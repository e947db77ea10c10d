# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A node's parameters: declared with descriptors, checked before they are set, then acted on."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from diffcal_ros.errors import InputError
from diffcal_ros.live.node_words import for_nodes
from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.node import Node
from rclpy.parameter import Parameter

Values = Mapping[str, Any]


@dataclass(frozen=True)
class Setting:
    """One parameter.

    Attributes:
        name: as in YAML.
        default: its type is the parameter's type.
        description: what it does, with its unit.
        low: smallest value allowed, or None without a range.
        high: largest value allowed.
        choices: the only values allowed; empty for any.
        is_read_only: given at the start only.
    """

    name: str
    default: Any
    description: str
    low: float | None = None
    high: float | None = None
    choices: tuple[str, ...] = ()
    is_read_only: bool = False

    def descriptor(self) -> ParameterDescriptor:
        """Return the descriptor."""
        described = ParameterDescriptor(description=self.description, read_only=self.is_read_only)
        if self.choices:
            described.additional_constraints = f'one of {", ".join(self.choices)}'
        if self.low is not None and self.high is not None:
            if isinstance(self.default, int):
                bounds = IntegerRange(from_value=int(self.low), to_value=int(self.high))
                described.integer_range = [bounds]
            else:
                span = FloatingPointRange(from_value=self.low, to_value=self.high)
                described.floating_point_range = [span]
        return described

    def problem(self, value: Any) -> str | None:
        """Say what is wrong with a value, or None."""
        if self.choices and value not in self.choices:
            return f'{self.name} is {value!r}: use one of {", ".join(self.choices)}'
        return None


class Parameters:
    """The parameters of one node."""

    def __init__(
        self,
        node: Node,
        settings: Sequence[Setting],
        *,
        check: Callable[[Values], None] = lambda values: None,
        check_change: Callable[[Values, Values], None] = lambda old, new: None,
        act: Callable[[frozenset[str]], None] = lambda changed: None,
    ) -> None:
        """Declare them.

        Args:
            node: whose they are.
            settings: one a parameter.
            check: raises InputError when values do not go together.
            check_change: raises InputError when values cannot be gone over to while the node runs;
                gets those in force and the new ones.
            act: told what was changed, after it was.

        Raises:
            InputError: when a value given at the start is not allowed.
        """
        self._settings = {setting.name: setting for setting in settings}
        self._check = check
        self._check_change = check_change
        self._act = act
        self.values: dict[str, Any] = {}
        for setting in settings:
            self.values[setting.name] = _declared(node, setting)
        problem = self._problem(self.values)
        if problem is not None:
            raise InputError(problem)
        node.add_on_set_parameters_callback(self._on_set)
        node.add_post_set_parameters_callback(self._on_changed)

    def __getitem__(self, name: str) -> Any:
        return self.values[name]

    def _on_set(self, parameters: list[Parameter]) -> SetParametersResult:
        ours = {p.name: p.value for p in parameters if p.name in self._settings}
        new = {**self.values, **ours}
        problem = (self._problem(new) or self._change_problem(new)) if ours else None
        return SetParametersResult(successful=problem is None, reason=problem or '')

    def _on_changed(self, parameters: list[Parameter]) -> None:
        ours = {p.name: p.value for p in parameters if p.name in self._settings}
        changed = frozenset(name for name in ours if ours[name] != self.values[name])
        self.values.update(ours)
        if changed:
            self._act(changed)

    def _problem(self, values: Values) -> str | None:
        for name, setting in self._settings.items():
            problem = setting.problem(values[name])
            if problem is not None:
                return problem
        return _reason(lambda: self._check(values))

    def _change_problem(self, new: Values) -> str | None:
        return _reason(lambda: self._check_change(self.values, new))


def _reason(check: Callable[[], None]) -> str | None:
    """Return what a check complains of, or None."""
    try:
        check()
    except InputError as error:
        return for_nodes(str(error))
    return None


def _declared(node: Node, setting: Setting) -> Any:
    try:
        declared = node.declare_parameter(setting.name, setting.default, setting.descriptor())
    except (InvalidParameterTypeException, InvalidParameterValueException) as error:
        raise InputError(
            f'parameter {setting.name} cannot be set ({error}): {setting.description}'
        ) from error
    return declared.value
