# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Launching the same kernels again and again: arguments are packed once and kept."""

import math
from threading import Lock
from typing import Any

import warp as wp

# Loading a module from two threads at once may lose one of its kernels.
_LOADING = Lock()


class Launcher:
    """Launches kernels on one device.

    Packing the arguments of a launch takes longer than many of these kernels run. Each kernel's
    last launch is kept, and only arguments that are other objects than last time are packed anew.
    Structs are packed by value, so a changed one must be a new object.
    """

    def __init__(self, device: str) -> None:
        self.device = device
        self._recorded: dict[Any, tuple[Any, list[Any]]] = {}
        self._dims: dict[Any, Any] = {}

    def launch(self, kernel: Any, dim: Any, inputs: list[Any], outputs: list[Any]) -> None:
        """Launch a kernel; see `warp.launch`."""
        if not (dim if isinstance(dim, int) else math.prod(dim)):
            # Warp records nothing for an empty launch, and there would be nothing to repeat.
            return
        arguments = [*inputs, *outputs]
        recorded = self._recorded.get(kernel)
        if recorded is None:
            with _LOADING:
                command = wp.launch(
                    kernel,
                    dim=dim,
                    inputs=inputs,
                    outputs=outputs,
                    device=self.device,
                    record_cmd=True,
                )
            self._recorded[kernel] = command, arguments
        else:
            command, last = recorded
            if self._dims[kernel] != dim:
                command.set_dim(dim)
            for index, (new, old) in enumerate(zip(arguments, last, strict=True)):
                if new is not old:
                    command.set_param_at_index(index, new)
                    last[index] = new
        self._dims[kernel] = dim
        command.launch()
