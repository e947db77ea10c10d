# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is wrong with a set-up of the sets of motions: numbers that are 0 else."""

from dataclasses import dataclass

from benchmarks.blind.later_faults import Vector


@dataclass(frozen=True)
class SwingFaults:
    """Amplitudes that came with the sets of motions, and what older ones say there.

    `stamps_form` may be `backlog`: images are stamped where they leave a queue, which grows frame
    by frame until one is dropped; `rolling`: rows are read one after another over twice
    `stamps_late`, which is how late the stamp is for the middle one; or `exposed`: an image is the
    mean of what is there over twice `stamps_late`. `drag_form` may be `laminar`: by the speed to
    the power of one and a half, as much as the square at half a metre per second; or `sail`: a
    piece of clear film at one place, as wide as the body's broad side. `creep_form` may be
    `power`: by a power of the time since the load; `flowing`: all stresses are lost at last, with
    one relaxation time; or `pour`: of what lies near the clamp alone. `tilt_form` may be
    `yielding`: a table leans over once the ledge bears nothing.

    In the set `swings_two`, `stamps_form` may be `polled`: images are stamped where a driver asks
    for them, which it does every twice `stamps_late`; or `set over`: a clock that is off is set
    while it stamps. `drag_form` may be `cup`: half a hollow ball at one place, which moves more
    easily with its round side ahead.
    `creep_form` may be `root`: by the exponential of the root of the time since the load.
    `clamp_form` may be `boot`: a sleeve of rubber, which is as soft all along what is held.
    `tilt_form` may be `swaying`: a table on air, which leans to and fro. `depth_form` may be
    `switched on`: a sensor that warms up, whose error falls by the exponential of the time.

    In the set `swings_three`, `stamps_form` may be `stalled`: a computer that did something else
    once stamps what piled up late. `drag_form` may be `vane`: a plate that stands aslant at one
    place. `creep_form` may be `warmed`: with one relaxation time, which falls as a lamp warms
    the body. `clamp_form` may be `putty`: it holds as a boot does at first, and gives way ever
    more.

    In the set `swings_four`, `stamps_form` may be `swept`: a mirror sweeps a beam over the columns
    within twice `stamps_late`, one image from the left to the right and the next one back.
    `drag_form` may be `tuft`: bristles on one place, which bend out of the stream's way.
    `creep_form` may be `setting`: with one relaxation time, which grows as a body sets.
    `tilt_form` may be `toppling`: a table that falls over from one foot to another. `clamp_form`
    may be `gel`: it holds as a boot does, and back by the speed as well. `curvature_form` may be
    `unrolling`: an arc, of which there is ever less after the release. `depth_form` may be `in
    turn`: every other frame alone errs.

    In the set `swings_five`, `stamps_form` may be `interlaced`: even rows are read in one pass,
    odd ones twice `stamps_late` later. `drag_form` may be `furred`: around what is beyond
    `drag_at`, by the power of four thirds. `creep_form` may be `oiled`: by the exponential of the
    depth below the surface. `clamp_form` may be `bracket`: of sheet metal, which turns about its
    bend. `tilt_form` may be `breeze`: a steady, level stream. `contrast_mode` may be `frothed`: of
    bubbles that rose to the upper side at the clamp. `depth_form` may be `dented window`: by how a
    plate bends that is pressed at `depth_spot` and held `depth_width` around that.

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
        stamps_asked: time since a driver asked for an image, at the first frame, as a share of
            that until it asks again.
        stamps_set: number of the first frame after a clock was set.
        drag_mouth: 1 where a cup's mouth looks along the object's z, -1 where the other way.
        tilt_rate: of a table that sways [Hz].
        tilt_phase: at the release [rad].
        depth_time: over which the error of a sensor that warms up falls to a third [s].
        chain_mass: of a fine chain along one side, up to the tip [g].
        chain_from: share of the free length where it begins.
        chain_side: 1 where that is the side of positive y, -1 where it is the other one.
        leash: stiffness of a rubber cord to a place of the body once it is taut [N/m].
        leash_at: that place's share of the free length.
        leash_post: where it is tied to the rig, object frame [mm].
        leash_taut: how far that place has gone away from the post where it is taut, over how far
            it goes where the body rests.
        doppler: by how much a range is too long, over the rate at which it grows [ms].
        stamps_stall: number of the frame at which a computer did something else.
        stamps_drain: frames in which what piled up by then is worked off.
        smoothing: share of the depth shown before that a filter keeps at each pixel.
        drag_slant: of a vane's normal, from the object's z towards its y [deg].
        creep_haste: how many times as fast a body relaxes at last that a lamp warms.
        creep_warmth: over which a third is left of what that has yet to grow [s].
        leak_mass: of water that runs out of a cup from the release on [g].
        leak_at: share of the free length where that stands.
        leak_time: until it is empty [s].
        putty_give: how far a spring as stiff as putty is at first would be drawn out by the most
            that this holds [mm].
        camera_hold: time by whose tenfold and so on a camera droops by `camera_turn` [s]; 0: it
            does not, and is off by that from the first.
        wool: stiffness at first of all the wadding on which the outer part comes to lie [N/m].
        wool_from: share of the free length from which on there is some.
        wool_top: how low it begins, over how far the lowest place above it goes down to rest.
        wool_floor: how low the floor below it is, likewise.
        gust: most that a gust pushes with, spread over the free surface [N].
        gust_from: when it begins, after the release [s].
        gust_time: how long it blows [s].
        gust_way: where it pushes, object frame, of length 1.
        rippled: most error of a depth over the rate at which it grows there [ms].
        ripple_period: of that over the image's columns [px].
        ripple_phase: at the first column [rad].
        drag_bends: speed of a tuft from about which on it bends [m/s].
        creep_set: over which a third is left of the rate at which a body relaxes that sets [s].
        tilt_fall: until a table that topples has come to its other foot [s]; it falls as a
            pendulum upside down, by the hyperbolic cosine of the time over `tilt_time`, less 1.
        clamp_time: over which a third is left of what gel has yet to give way by [s].
        balls: of all rubber balls below the outer part, force by the power of one and a half of
            how far they are flattened [N/m^1.5].
        balls_from: share of the free length from which on there are some.
        balls_top: how low their tops are, over how far the lowest place above goes down to rest.
        curvature_time: until half of a bend is left that unrolls [s].
        depth_turn: remainder by two of the numbers of those frames, from 0, that err in turn.
        remanent: pull of a ledge's magnet on the end face as it is switched off [N].
        remanent_time: over which a third of that is left [s].
        remanent_way: where it draws, object frame, of length 1.
        tearing: by how much log E falls on the upper face amid tears.
        tearing_at: share of the free length where that is.
        tearing_time: when it tears, after the release [s].
        creep_depth: way below the surface over which oil falls to a third [mm].
        bracket_drop: how far a bracket's bend lies below what is held, at the object's origin
            along x [mm].
        breeze_speed: of the air [m/s].
        pack_mass: of a flat pack on the lower side [g].
        pack_from: share of the free length where that begins.
        pack_until: and where it ends.
        rubbed: dry friction of felts on one place [N].
        rubbed_at: that place's share of the free length.
        lurched: how far a rig lurches as the ledge goes, at most [mm].
        lurched_time: half of the time until it is that far [s].
        lurched_way: direction in the world, of length 1.
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
    stamps_asked: float = 0.0
    stamps_set: int = 0
    drag_mouth: float = 0.0
    tilt_rate: float = 0.0
    tilt_phase: float = 0.0
    depth_time: float = 1.0
    chain_mass: float = 0.0
    chain_from: float = 0.0
    chain_side: float = 0.0
    leash: float = 0.0
    leash_at: float = 0.0
    leash_post: Vector = (0.0, 0.0, 0.0)
    leash_taut: float = 0.0
    doppler: float = 0.0
    stamps_stall: int = 0
    stamps_drain: float = 1.0
    smoothing: float = 0.0
    drag_slant: float = 0.0
    creep_haste: float = 1.0
    creep_warmth: float = 1.0
    leak_mass: float = 0.0
    leak_at: float = 0.0
    leak_time: float = 1.0
    putty_give: float = 1.0
    camera_hold: float = 0.0
    wool: float = 0.0
    wool_from: float = 0.0
    wool_top: float = 0.0
    wool_floor: float = 0.0
    gust: float = 0.0
    gust_from: float = 0.0
    gust_time: float = 1.0
    gust_way: Vector = (0.0, 0.0, 0.0)
    rippled: float = 0.0
    ripple_period: float = 1.0
    ripple_phase: float = 0.0
    drag_bends: float = 0.0
    creep_set: float = 1.0
    tilt_fall: float = 1.0
    clamp_time: float = 0.0
    balls: float = 0.0
    balls_from: float = 0.0
    balls_top: float = 0.0
    curvature_time: float = 1.0
    depth_turn: int = 0
    remanent: float = 0.0
    remanent_time: float = 1.0
    remanent_way: Vector = (0.0, 0.0, 0.0)
    tearing: float = 0.0
    tearing_at: float = 0.0
    tearing_time: float = 0.0
    creep_depth: float = 1.0
    bracket_drop: float = 0.0
    breeze_speed: float = 1.0
    pack_mass: float = 0.0
    pack_from: float = 0.0
    pack_until: float = 1.0
    rubbed: float = 0.0
    rubbed_at: float = 0.0
    lurched: float = 0.0
    lurched_time: float = 1.0
    lurched_way: Vector = (0.0, 0.0, 0.0)
