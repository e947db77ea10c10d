# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Moving NumPy arrays to and from Warp arrays; on the CPU without copies in between."""

from typing import Any

from diffcal_ros.errors import InputError
from diffcal_ros.warp_runtime.start import start_warp
import numpy as np
from numpy.typing import NDArray
import warp as wp

start_warp()


def require_device(name: str) -> None:
    """Refuse a device that this machine lacks.

    Raises:
        InputError: listing the devices there are.
    """
    known = device_names()
    if name not in known:
        raise InputError(
            f'device is {name!r}: this machine has {", ".join(known)}; name one of these, and '
            'where a GPU is missing see that nvidia-smi lists it'
        )


def upload(target: Any, values: NDArray[Any]) -> None:
    """Fill a Warp array from a NumPy array of the same size."""
    if target.device.is_cpu:
        view = target.numpy()
        view[...] = values.reshape(view.shape)
    else:
        target.assign(values)


def download(source: Any) -> NDArray[Any]:
    """Return a copy of a Warp array as NumPy."""
    values: NDArray[Any] = source.numpy()
    return values.copy() if source.device.is_cpu else values


def device_names() -> tuple[str, ...]:
    """List the devices that this machine has: `cpu`, and GPUs such as `cuda:0`."""
    return tuple(str(device.alias) for device in wp.get_devices())


def point_array(values: NDArray[np.float64], device: str) -> Any:
    """Return vectors in double precision; the last axis of `values` has length 3."""
    return wp.array(np.ascontiguousarray(values), dtype=wp.vec3d, device=device)


def float_array(values: NDArray[np.float64], device: str) -> Any:
    """Return numbers in double precision."""
    return wp.array(np.ascontiguousarray(values), dtype=wp.float64, device=device)


def int_array(values: NDArray[np.integer[Any]], device: str) -> Any:
    """Return 32-bit integers."""
    return wp.array(np.ascontiguousarray(values), dtype=wp.int32, device=device)


def shared(values: NDArray[Any], dtype: Any, device: str) -> Any:
    """Return numbers that neither side will change; on the CPU in the same memory."""
    return wp.array(np.ascontiguousarray(values), dtype=dtype, device=device, copy=False)


def zero_points(shape: int | tuple[int, ...], device: str) -> Any:
    """Return zero vectors in double precision."""
    return wp.zeros(shape, dtype=wp.vec3d, device=device)


def zero_floats(shape: int | tuple[int, ...], device: str) -> Any:
    """Return zeros in double precision."""
    return wp.zeros(shape, dtype=wp.float64, device=device)


def zero_ints(shape: int | tuple[int, ...], device: str) -> Any:
    """Return 32-bit integer zeros."""
    return wp.zeros(shape, dtype=wp.int32, device=device)


class HostMirror:
    """A Warp array that is read and written often: on the CPU its memory is looked up once."""

    def __init__(self, array: Any) -> None:
        self.array = array
        self._view: NDArray[Any] | None = array.numpy() if array.device.is_cpu else None

    def write(self, values: NDArray[Any]) -> None:
        """Fill the array."""
        if self._view is None:
            self.array.assign(values)
        else:
            self._view[...] = values

    def read(self) -> NDArray[Any]:
        """Return a copy."""
        if self._view is None:
            values: NDArray[Any] = self.array.numpy()
            return values
        return self._view.copy()

    def clear(self) -> None:
        """Fill the array with zeros."""
        if self._view is None:
            self.array.zero_()
        else:
            self._view.fill(0.0)
