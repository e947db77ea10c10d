# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is wrong with a set-up: numbers that are 0 where nothing is.

Frames: `camera` optical; `world` of the room, y up; `object` that of the mesh, x from the clamp
to the tip. "Body's centre" is the middle of the nominal mesh's bounding box as placed.
"""

from dataclasses import dataclass

from benchmarks.blind.later_faults import LaterFaults, Vector
from benchmarks.blind.recent_faults import RecentFaults
from benchmarks.blind.swing_faults import SwingFaults


@dataclass(frozen=True)
class Faults(SwingFaults, LaterFaults, RecentFaults):
    """Amplitudes of all effects, those of the last sets aside.

    Attributes:
        camera_shift: the true camera stands this far from the stored one, camera frame [mm].
        camera_turn: and is turned so about the body's centre, camera frame [deg].
        depth_scale: measured = (1 + scale) z + bias [%].
        depth_bias: likewise [mm].
        region_bias: added to z where the half at the tip is seen [mm].
        gravity_tilt: rotation vector of gravity about the world's x and z [deg].
        added_mass: [g].
        added_mass_at: share of the free length.
        contact_height: a frictionless half-space that the body may touch lies below
            normal . x = height in the world [m]; None: there is none.
        contact_normal: its normal in the world.
        clamp_shift: the held section is shifted from its stated place, object frame [mm].
        clamp_turn: and turned about its centre, object frame [deg].
        clamp_compliance: turn of the held section by its moment, about its centre [rad/(N m)].
        rest_curvature: turn per length of the body without stress, about the object's y and z
            [1/m].
        contrast: log E of the tip less that of the clamp's end; the mean stays.
        contrast_mode: `split` at half the free length, `linear` along it, `smooth` about two
            fifths of it, in `thirds`, of the `skin` against the core, a `cosine` over the whole
            length, `late` at seven tenths, with the `square` of the place, of a `spot`
            from two to four tenths against all else, by `three pours`: a step of three fifths
            of it at a quarter, and of the rest at three fifths, of all else against a `sleeve`
            around the inner two fifths, `decaying`: of all that is far out against the clamp's
            end, from where it falls by the exponential of the place, of what lies below a
            `lamp`, above `contrast_at`, against all that is far from it, of two pours whose
            border at `contrast_at` is `slanted`: farther out on the upper side, of what is
            `patched`, from there to `contrast_until` on one side, against all else, `streaky`:
            by the sine of the place, aslant, of a tube that is `cored` into the middle of the
            section, up to `contrast_at`, against all else, of a root that is `plugged` by a
            cone, which fills the section at the clamp and comes to its point there, of some
            `pours` that are alike in length, each of a cup of its own, of a `foil` on the
            upper side, from there to `contrast_until`, of what `settled` towards the clamp: it
            falls evenly to none there, of the swirls of a rubber that is `marbled`, by their
            standard deviation, of what was `overbent` at `contrast_at`: it falls evenly to
            none at the clamp and at the tip, and to none amid the height, of what was
            `soaked` from `contrast_at` on: by the exponential of the depth below its surface,
            of what was `creased` at `contrast_creases`: by the exponential of the square of the
            way along it, of an `edged` body's four long edges: by the places along both sides,
            of two pours that are `wedged`: their border goes from `contrast_at` on the side
            of `contrast_side` to `contrast_until` on the other one, of a `ribbon` that winds
            around the body's length, which is at the side of positive y at `contrast_at`, or of
            what is far from where a mould is `gated`: evenly by the way from `contrast_at`.
        yeoh_ratio: C2 / C1 [-].
        stiffening_form: of `stiffening`: `gent`, `fung`, `cubic` (Yeoh's third term),
            `mooney_rivlin`, `ogden` (of power four), `veronda_westmann`, `hart_smith`,
            `recruited`: of fibres that lie in waves until they are drawn straight, `braided`: of
            threads aslant to the body's length, by the exponential of the square of their
            growth, `knitted`: of loops along it near the surface, by the cube of that,
            `beaded`: of rows of beads along it, where they are pressed, by the cube of that,
            `threaded`: of threads along it near the surface, which are loose at first,
            `coils`: of those of a spring there, which touch once they are pressed together,
            `interlocked`: of the strips of a hose there, which have play either way, `leads`:
            of those of a sensor along the middles of both sides, which are loose at first,
            `vertebrae`: of blocks along the lower side, which touch once they are pressed, or
            `ruffled`: of a tape on the upper side, which lies in waves until it is drawn straight.
        stiffening: 1 / Jm of Gent's law, the exponent of Fung's, of Veronda's and Westmann's or of
            Hart-Smith's, C3 / C1, the share of the shear modulus at rest that the form has, the
            modulus of all fibres, were they straight and not slack, or that at first of a braid
            along the body, or of loops whose square grew by a tenth, or of rows of beads whose
            square fell by that, or of threads, leads or a tape once they are taut, or of coils or
            blocks that touch, or of strips once their play is used up, over E [-].
        mass_form: how an added mass is spread: `hat` over a tenth of the length, `ring` around
            the surface, `smear` over half the length, `point` on one side, `two` rings, the other
            one half as far out, a `coat` from there to the tip, two points on `opposite` sides,
            one half as far out, at the end of a rigid `arm`, or a sensor with its `cable`: half
            of it there, half evenly from the clamp to there, both on the upper side; or what
            hangs of a `trailing` cable between the side of positive y and a table: more where
            that place is higher; a `loose` ring, which slides as far as `mass_stops`; a wet
            cloth around all between these, which is `drying`; a liquid `pooled` where a channel
            between them is lowest; a film that `drained` down the surface from the clamp on;
            `markers`: balls on stalks, evenly from one of these to the other; a `tool`, whose
            middle is ahead of the place that carries it; a cable `slung` from the rig to that
            place, which draws it down and towards the rig; a wet `sponge` around all between
            `mass_stops`, whose water sinks to where that is lowest; a lump of grease that is
            `oozing` along the body: in each pose at one of `mass_places`; a cord that is
            `wicking` a liquid from the clamp on: in each pose as far as one of these; a clip
            that is `hung on` there before the pose `mass_from`; `mass_drips` of glue with
            which a body was `spattered`; a weight that is `cradled` in two threads, from both
            of `mass_stops`; or a cup that is `filling`: in each pose by `mass_shares`.
        clamp_form: how a clamp gives way: `turn` alike about all axes, `uneven` about one axis
            only, `shear` along the force [m/N], `jaw`, a soft root, or with a stiffness
            by a power of the moment, as given at the body's weight: `hardening` 0.5, `softening`
            -0.4; `about a corner` of the held section, three times as much about its y as
            about its z; `one-sided`, as far as the moment has the signs of `clamp_way`; or a
            `lined` jaw, whose foam yields at each place by the pressure there, and more at the
            mouth: in all as much as is given, where the body is rigid; on a `flexure`, which
            shifts and turns it by force and moment as the end of a leaf spring; with a `play`
            through which it turns at first as is given, and then no more; `preloaded`: not at
            all up to a moment of `clamp_preload`, and as is given by what goes beyond that;
            `rubbing`: as given but for a moment of `clamp_rub`, by which it lags behind;
            `creeping`: in each pose by a part `clamp_crept` of what it lacks to that; on a
            `post`, which shifts and turns it by force and moment as the end of an upright rod;
            on an `angle iron` along the object's x, which bends most about `clamp_slant`; on a
            robot's `wrist` of three joints about the object's axes, two of them behind it;
            `glued`: by the lower face alone, but for what `clamp_gape` says; `taped` to what
            lies below it by a square of foam tape, which it shifts and turns on; in `hot
            glue`, which grows softer: in each pose by `clamp_shares` of what is given;
            `waxed` in: in each pose it flows on as is given, from where the one before left it;
            amid the crossbar of a `gantry` along the object's y, which twists as is given; on
            the arm of a `stand`, which bends with the rod that bears it; on a `suction` cup
            behind it, which it shifts and turns on; or on a plate on four rubber `bobbins`.
        tilt_form: `tilt` of gravity, or a further force on every part in proportion to its mass,
            as `gravity_tilt` says to first order: `side_force` steady in the world, `rig_force`
            steady in the object's frame, `growing` steady in the world and in proportion to the
            place along the body as well, `outer_push` on the outer two fifths alone,
            `middle_push` six times as much on the middle third alone; a tilt `changing` by
            30 % of its mean from pose to pose; a `thread` that draws one place with the force
            of all the body's mass; a `turntable`, which draws every part away from its axis
            in proportion to the distance, and where the camera looks as is given; a tilt on
            `castors`, whose way turns about the world's y by `tilt_turn` from pose to pose; a
            `blower`, which presses what faces it by the square of the cosine, as hard as would
            draw all the body's mass, did its largest side face it squarely; a `draught`: a
            round stream through `tilt_point`, as is given on its axis, which falls beside that;
            a `layer` of air over a bench, which goes with the square of the height, and is as
            given where the camera looks; an `extractor`, which draws all towards its mouth at
            `tilt_point` by the fourth power of the distance, as hard as given there; a `fan`
            that swings, whose push is steady in a pose and another in each; a table that is
            `floating` on soft feet: a tilt to which `tilt_scatter` comes in each pose; an arm
            that is `braking`: gravity is not turned, and `tilt_pushes` come to it; a table
            that is `rocking` on a short leg: in each pose a tilt one way or back; a trolley
            with a tyre that is `deflating`: in each pose by `tilt_shares` of a tilt; two fans
            that are `opposed`: one pushes what is beyond `tilt_at` as is given, the other what is
            before that by `tilt_back` of it the other way; a `curtain` of air: an upright sheet
            through `tilt_point`, as is given amid it, which falls beside that; or a `hair dryer`,
            whose jet spreads: as is given at `tilt_point`, `tilt_away` from its mouth.
        curvature_form: `arc`, `tip` (the outer half alone), `root` (the inner one), `twist`
            about the body's length, `S` (twice as much, one way in the inner half and the other
            in the outer), `middle` (three times as much in the middle third alone), `helix`
            (the plane of bending turns by 150 degrees along the body), or the `set` of a body
            that hung for long (by the square of the distance to the tip, twice as much at the
            clamp: its tip moves as far as an arc's), a `kink`: ten times as much in a tenth
            of the free length alone, around `curvature_at`, that of a mould on two
            `trestles`, which sagged by its weight between and beyond them (the tip moves as far
            as an arc's), `coiled`: a spiral, whose radius falls evenly to three tenths at the
            tip (which moves as far as an arc's), `draped` over a rail at `curvature_at`, from
            which both ends hung (the tip moves as far as an arc's), `buckled` between two
            walls: by the sine of the place (the tip moves as far as an arc's), `folded`: a
            kink at `curvature_at`, and one the other way at `curvature_again`, `weighed down`
            at `curvature_at` between two supports (the tip moves as far as an arc's),
            `overhanging` a table's edge at `curvature_at` (the tip moves as far as an arc's),
            `wavy`: by the sine of some waves (the tip moves as far as an arc's), `crammed`
            into a box: a bend around `curvature_at`, and one at right angles to that around
            `curvature_again`, `jumbled`: by `curvature_parts`, each bent its own way (the tip
            moves as far as an arc's), `propped` at its tip: by the moment of its weight less
            that of a block (the tip moves as far as an arc's), `outweighed` by its holder over
            a shelf's edge at `curvature_at` (the tip moves as far as an arc's), `held by its tip`:
            by the moment of its weight and its holder's (the tip moves as far as an arc's), or
            `burdened` by what hung at `curvature_at` (the tip moves as far as an arc's).
        clamp_steps: whether a shift of the clamp grows from pose to pose.
        clamp_late: whether it is there in the second half of the poses only.
        contact_form: `hard`, `foam`, whose pressure grows with the square of the dent, a
            `shelf` that ends before the inner half, an `edge`: a round bar, `friction`, which
            holds the body back where it comes to the plane, a plane on the `rig`, which goes
            with it: normal and height are in the object's frame, or a `mat` of foam on it, which
            yields to the pressure the less the thinner it is pressed, a `roll` of foam along
            the world's z, a block with a `step`, which begins below the outer half and is
            lower beyond `contact_share`, a `vee`: a groove along the world's x, the `pan` of a
            balance, which sinks by all of the force on it, a round `dish` below the outer part,
            a rubber `rope` along the world's z between two posts, the round `knob` at the end
            of a screw that goes with the rig, a `brush`, whose bristles bend over, a soft and
            round `cushion` below the outer part, the foam of a `crate` for eggs, a `flap`
            below the outer part, which turns about a hinge along the world's z, `felt`, whose
            pressure grows by the exponential of the dent, a table for `hovering`, which blows:
            its pressure falls by the exponential of the height over it, a piece of `pipe`
            along the world's x below the outer part, the foam of `packing`, whose cells buckle:
            its pressure comes up to a most by the exponential of the dent, the round bars of a
            drying `rack` along the world's z, or a hard plane on a `jack`, which sinks by
            `contact_drops`.
        depth_form: how the error that `depth_bias` gives varies: `affine`, `radial` (with the
            square of the distance from the image's middle), `drift` from pose to pose,
            `disparity` (with the square of the depth), `ramp` across the image, `settling` by
            three tenths from pose to pose, by `temperature`: it rises and falls over the poses,
            while that of `depth_scale` grows from nothing; by `incidence`: over the cosine of
            the angle between ray and surface, up to three times; `near field`: it falls by
            the exponential of the depth; `walk`: by the logarithm of the light that returns,
            which falls with the square of the depth and that angle's cosine; `upper rows`: it
            falls by the exponential of the row, from the image's upper edge on; or that of an
            `entry` of the table by which a sensor corrects depths: it falls evenly to nothing
            over `depth_spacing` on either side of `depth_entry`; that of a `veil` of light from
            `depth_veil`, by the light that returns; of an imager of a stereo pair that is
            `toed` in and rolled: with the square of the depth, and evenly over the rows; of a
            `smudge` on a window, round `depth_spot`: by the exponential of the square of the way;
            of pixels that are `saturated`: by the light beyond `depth_full`; of light that
            `bounced` from `depth_point`: by the inverse square of the distance from there; of
            a frame that is `exposed` by the mean of its light: by the inverse of that; of a
            `sunbeam` through `depth_spot`, which wanders from pose to pose: by the exponential
            of the square of the way from its middle; of a fixture that has `flared`: by the
            exponential of the way from that in the image; of a sensor that is `warped` to a
            saddle: by the square of the way along `depth_slant` less that across; of one that
            is `restarted` before each pose: by `depth_shares`; of a film that is `peeling` off
            its window: of what is seen through it, beyond one of `depth_places` in each pose; of
            one with `two gains`: of what returns more light than `depth_full`; or of one behind a
            bent `splash guard`: by the square of the way along `depth_slant`.
        region_from: share of the free length from which on `region_bias` is added.
        focal_scale: true focal lengths over the stated ones, less 1.
        aspect: by how much more the one across is, and the one down less.
        center_shift: true principal point less the stated one [px].
        wind: further horizontal body force on the half at the tip, along the world's z, as a
            share of its weight [-].
        swelling: free growth of every length in the half at the tip [%].
        bulge: share by which the true section is wider in the middle than the stated one.
        soft_skin: log E of the outer layer of elements on the upper side.
        radial_distortion: first radial coefficient of a lens that was taken for ideal.
        stamps_late: an image stamped t shows the body at t less this [ms].
        stamps_form: `constant`, `drift` (from a half to one and a half of it over the recording),
            or `jitter` (each stamp by a third of it more or less).
        drag_area: drag coefficient times area of the free surface [cm^2].
        drag_form: `square` of the speed, `linear` beside it (as much at half a metre per second),
            or `normal` (faces feel the square of the speed across them, along their normal).
        creep_share: g of a Prony pair: all stresses relax to 1 - g of what they were [-].
        creep_time: tau of that pair [s].
        creep_form: `one` pair, or `two` with half the share each, the other five times as slow.
        contact_share: share of the free length that lies over a bar, also one of a rack's, a rope,
            a knob or the edge of a step.
        contact_at: where the axis of the bar, or of one of a rack's, is along the world's x, the
            groove's bottom or a pipe's axis along z, or a knob's top along the object's y [m].
        camera_drifts: whether the camera's error grows from pose to pose.
        clamp_scatter: further shift [mm] and turn [deg] of the clamp in each pose.
        region_ramp: share of the free length over which `region_bias` comes up.
        magnet: pull on the outer part towards a point of the world [N].
        tether: pull of a spring on the tip towards a point of the world [N].
        tether_slack: its length without a force, as a share of `pull_distance`.
        pull_point: that point, or where a reel is, world [m].
        pull_distance: at which the pull is as much as stated [m].
        heat: growth of the upper face, falling to none at the lower one [%].
        heat_shares: how much of that is there in each pose.
        cone: share by which the true section is smaller at the tip than the stated one.
        torn: share of the height, from above, that hardly holds together any more in a piece of a
            tenth of the free length; to the nearest row of Gauss points.
        torn_at: share of the free length of its middle.
        wiggle: amplitude of an error of depth that goes with the sine of the depth [mm].
        wiggle_period: of the depth [mm].
        wiggle_phase: [rad].
        camera_from: number of the pose from which on the camera is off.
        clamp_by_load: whether the clamp's shift and turn are there as far as the share of the
            weight that is across the body goes beyond seven tenths.
        clamp_way: signs of the moments about y and z to which a clamp gives way.
        mass_arm: from the body's middle to an added mass at its end, or to each of some markers,
            object's y and z [mm].
        region_slant: by which share of the free length the border of `region_bias` is farther
            out at the side of positive y than in the middle.
        hollow: share of the free length of a cavity, three fifths of the body wide, in its upper
            half.
        hollow_at: share of the free length of its middle.
        jet: force of a jet of air on one place [N].
        jet_at: that place's share of the free length.
        jet_normal: direction of the force, object frame.
        jet_shares: how much of it is there in each pose.
        stripes: amplitude of an error of depth that goes with the sine of the column [mm].
        stripes_period: [px].
        stripes_phase: [rad].
        warming: log E in the first pose less that in the last.
        camera_foot: what a wrong camera turns about in place of the body's centre, stored camera
            frame [m]; None: that centre.
        camera_sags: whether the camera is right in the first pose and then sags, less and less,
            until it is as far off as stated in the last.
        region_until: share of the free length up to which `region_bias` is added.
        hose: stiffness of a hose that goes with the rig and holds one place of the body [N/m].
        hose_at: that place's share of the free length.
        hose_offset: from that place without a load to where the hose would have it, object
            frame [mm].
        parted: share by which the true body is higher along z than the stated one.
        memory: share of the pose before in what a body rests under.
        tiles: standard deviation of an error of depth that each square of the image has of its
            own [mm].
        tiles_edge: of a square [px].
        tiles_seed: of what is drawn for the squares.
        tangential: two coefficients of tangential distortion, of x y and y^2 in the columns and
            rows, and of x^2 and x y.
        clamp_slid: by how much the body has slid out of its clamp along the object's x [mm].
        clamp_length: of a flexure, a post, an angle iron, half of a crossbar or a stand's arm,
            from a wrist's joint about y, of the edges of a square of foam tape, half as far
            below the middle of what is held, across a suction cup, as far behind that, or from
            bobbin to bobbin along x, half as far below that [m].
        region_above: whether `region_bias` is added on the upper half alone, where the object's
            z is positive.
        tilt_at: share of the free length of the place that a thread draws, or from which on the
            outer one of two fans is felt.
        curvature_at: share of the free length of the middle of a kink, a rail, a weight or an
            inner fold or bend, or of a table's or a shelf's edge, or where something hung.
        mass_table: how high a table lies in the world, on which a trailing cable ends [m].
        mass_drop: height above the table at which `added_mass` hangs, or by how much it is cradled
            below a body [m].
        bath: share of the weight of what is below a liquid's level that the liquid bears.
        bath_level: how high that is in the world [m].
        trimmed: length that was cut off at the tip [mm].
        fabric: by which share of E a fabric in the uppermost quarter stiffens a pull along the
            object's x; it is slack where it is pressed together.
        wobble: amplitude by which columns swing over the rows of the image [px].
        wobble_period: of rows [px].
        wobble_phase: [rad].
        focus_shares: how much of `focal_scale` and `center_shift` is there in each pose; empty:
            all of it.
        clamp_drag: shear of the held section: by how much its parts are shifted along the
            object's x, over their y and z from its middle [-].
        clamp_play: turn at which a clamp with play gives way no more [deg].
        contrast_at: share of the free length above which a lamp stands, where a border lies or a
            patch or a foil begins, or where a body was bent most, or a ribbon is at one side, or
            up to which a tube, a plug or what settled reaches, or of a mould's gate.
        contact_step: by how much a block is lower beyond its step [mm].
        tilt_radius: distance of a turntable's axis from where the camera looks [m].
        screen: force of a charged screen on the whole free body against the world's z, where the
            camera looks [N].
        screen_reach: way along z over which that falls to a third [m].
        coarse: step between the depths that a sensor tells [mm].
        stiffening_from: growth of a fibre's or a tape's square by which it comes straight, or of a
            loose thread's at which it comes taut, or loss of a coil's or a block's at which it
            touches, or either of a strip's that has play [-].
        mass_stops: shares of the free length of an inner and an outer stop of a loose ring, of the
            ends of a cloth or a sponge, of the first and the last marker, or of two threads.
        camera_scatter: further shift [mm] and turn [deg] of the camera in each pose.
        region_gloss: power of the cosine of the angle between ray and surface by which
            `region_bias` grows, to all of it where a surface is met squarely.
        contrast_slant: by which share of the free length a border between pours is farther out
            at the upper side than in the middle.
        tilt_turn: by how much a tilt turns from pose to pose [deg].
        racked: shift of the true body along y over its z [-].
        jump: what is added to z beyond `jump_from` [mm].
        jump_from: depth [m].
    """

    camera_shift: Vector = (0.0, 0.0, 0.0)
    camera_turn: Vector = (0.0, 0.0, 0.0)
    depth_scale: float = 0.0
    depth_bias: float = 0.0
    region_bias: float = 0.0
    gravity_tilt: tuple[float, float] = (0.0, 0.0)
    added_mass: float = 0.0
    added_mass_at: float = 0.0
    contact_height: float | None = None
    contact_normal: Vector = (0.0, 1.0, 0.0)
    clamp_shift: Vector = (0.0, 0.0, 0.0)
    clamp_turn: Vector = (0.0, 0.0, 0.0)
    clamp_compliance: float = 0.0
    rest_curvature: tuple[float, float] = (0.0, 0.0)
    contrast: float = 0.0
    contrast_mode: str = 'split'
    yeoh_ratio: float = 0.0
    stiffening_form: str = 'gent'
    stiffening: float = 0.0
    mass_form: str = 'hat'
    clamp_form: str = 'turn'
    tilt_form: str = 'tilt'
    curvature_form: str = 'arc'
    clamp_steps: bool = False
    clamp_late: bool = False
    contact_form: str = 'hard'
    depth_form: str = 'affine'
    region_from: float = 0.5
    focal_scale: float = 0.0
    aspect: float = 0.0
    center_shift: tuple[float, float] = (0.0, 0.0)
    wind: float = 0.0
    swelling: float = 0.0
    bulge: float = 0.0
    soft_skin: float = 0.0
    radial_distortion: float = 0.0
    stamps_late: float = 0.0
    stamps_form: str = 'constant'
    drag_area: float = 0.0
    drag_form: str = 'square'
    creep_share: float = 0.0
    creep_time: float = 1.0
    creep_form: str = 'one'
    contact_share: float = 0.0
    contact_at: float = 0.0
    camera_drifts: bool = False
    clamp_scatter: tuple[tuple[float, ...], ...] = ()
    region_ramp: float = 0.0
    magnet: float = 0.0
    tether: float = 0.0
    tether_slack: float = 0.0
    pull_point: Vector = (0.0, 0.0, 0.0)
    pull_distance: float = 0.0
    heat: float = 0.0
    heat_shares: tuple[float, ...] = ()
    cone: float = 0.0
    torn: float = 0.0
    torn_at: float = 0.0
    wiggle: float = 0.0
    wiggle_period: float = 0.0
    wiggle_phase: float = 0.0
    camera_from: int = 0
    clamp_by_load: bool = False
    clamp_way: tuple[float, float] = (1.0, 1.0)
    mass_arm: tuple[float, float] = (0.0, 0.0)
    region_slant: float = 0.0
    hollow: float = 0.0
    hollow_at: float = 0.0
    jet: float = 0.0
    jet_at: float = 0.0
    jet_normal: Vector = (0.0, 0.0, 0.0)
    jet_shares: tuple[float, ...] = ()
    stripes: float = 0.0
    stripes_period: float = 0.0
    stripes_phase: float = 0.0
    warming: float = 0.0
    camera_foot: Vector | None = None
    camera_sags: bool = False
    region_until: float = 1.0
    hose: float = 0.0
    hose_at: float = 0.0
    hose_offset: Vector = (0.0, 0.0, 0.0)
    parted: float = 0.0
    memory: float = 0.0
    tiles: float = 0.0
    tiles_edge: int = 0
    tiles_seed: int = 0
    tangential: tuple[float, float] = (0.0, 0.0)
    clamp_slid: float = 0.0
    clamp_length: float = 0.0
    region_above: bool = False
    tilt_at: float = 0.0
    curvature_at: float = 0.0
    mass_table: float = 0.0
    mass_drop: float = 0.0
    bath: float = 0.0
    bath_level: float = 0.0
    trimmed: float = 0.0
    fabric: float = 0.0
    wobble: float = 0.0
    wobble_period: float = 1.0
    wobble_phase: float = 0.0
    focus_shares: tuple[float, ...] = ()
    clamp_drag: tuple[float, float] = (0.0, 0.0)
    clamp_play: float = 0.0
    contrast_at: float = 0.0
    contact_step: float = 0.0
    tilt_radius: float = 0.0
    screen: float = 0.0
    screen_reach: float = 0.0
    coarse: float = 0.0
    stiffening_from: float = 0.0
    mass_stops: tuple[float, float] = (0.0, 0.0)
    camera_scatter: tuple[tuple[float, ...], ...] = ()
    region_gloss: float = 0.0
    contrast_slant: float = 0.0
    tilt_turn: float = 0.0
    racked: float = 0.0
    jump: float = 0.0
    jump_from: float = 0.0
