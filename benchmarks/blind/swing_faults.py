# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is wrong with a set-up of the set of motions `swings`: numbers that are 0 else."""

from dataclasses import dataclass

from benchmarks.blind.later_faults import Vector


@dataclass(frozen=True)
class SwingFaults:
    """Amplitudes that came with the set `swings`, and what older ones say there.

    `stamps_form` may be `backlog`: images are stamped where they leave a queue, which grows frame
    by frame until one is dropped; `rolling`: rows are read one after another over twice
    `stamps_late`, which is how late the stamp is for the middle one; or `exposed`: an image is the
    mean of what is there over twice `stamps_late`. `drag_form` may be `laminar`: by the speed to
    the power of one and a half, as much as the square at half a metre per second; or `sail`: a
    piece of clear film at one place, as wide as the body's broad side. `creep_form` may be
    `power`: by a power of the time since the load; `flowing`: all stresses are lost at last, with
    one relaxation time; or `pour`: of what lies near the clamp alone. `tilt_form` may be
    `yielding`: a table leans over once the ledge bears nothing.

    Attributes:
        stamps_phase: number of frames since a queue was empty, in the first frame.
        drag_at: share of the free length where a sail is.
        creep_power: of the time, negative slope of the stresses in logarithms [-].
        creep_until: share of the free length up to which a pour creeps.
        tilt_time: over which a table leans over to a third of what is left [s].
        end_mass: of a plate on the end face, by which a magnet held a body [g].
        shaken: amplitude of a rig that shakes, the camera does not [mm].
        shaken_rate: [Hz].
        shaken_phase: at the release [rad].
        shaken_way: direction in the world, of length 1.
        kicked: impulse that a ledge gives to the end face as it goes [N s].
        kicked_way: direction in the object's frame, of length 1.
    """

    stamps_phase: int = 0
    drag_at: float = 0.0
    creep_power: float = 0.0
    creep_until: float = 0.0
    tilt_time: float = 0.0
    end_mass: float = 0.0
    shaken: float = 0.0
    shaken_rate: float = 0.0
    shaken_phase: float = 0.0
    shaken_way: Vector = (0.0, 0.0, 0.0)
    kicked: float = 0.0
    kicked_way: Vector = (0.0, 0.0, 0.0)
