"""A payload moved by some joints near a pose: friction is free in each recording, not all ten need be visible."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...common import Array, Brief, InputError, Mask
from ...common.progress import each
from ...model import BaseParameters, Motion, Processing, Recording, Robot, base_parameters
from ...model.drives import parameter_kind
from ...model.motion import Measurement
from ...model.regressors import payload_columns
from ...model.visibility import PayloadVisibility, check_mass_visible, friction_columns, visibility_of
from ..equations.equations import PAYLOAD, Equations, merged
from ..equations.observer import PATH, Observation, Observer, Used, reduced
from ..fit.covariance import block_edges, block_length, in_blocks, remembered
from ..fit.estimate import Estimate
from ..fit.linear_problem import Known, LinearProblem
from ..fit.own_equations import check_lengths, filtered, under_own_load
from ..fit.settings import DEFAULTS, Settings
from ..possible.constraints import KnownMass
from ..signals.alignment import aligned
from ..signals.filtering import grid_rate, measurement
from ..signals.plausibility import check_apart, check_recordings, without_dead
from ..signals.rows import inner_samples, least_speed, moving_parts
from .long_motion import (
    Source,
    check_blocks,
    check_known,
    friction_changes,
    known_path,
    measured_part,
    prior_of,
    robot_of,
    stored_robot,
)
from .nuisance import (
    FREE,
    HeldFriction,
    Wave,
    coulomb_friction,
    free_columns,
    friction_prior,
    offset_prior,
    ripple_of,
)
from .pairs import torque_change
from .result import in_payload_frame

SLOW = 0.03
"""Speed [rad/s or m/s] of a joint below which rows are not used; the sign of its friction is not sure there."""
_LEAST = 0.1  # of the moving time: a joint that moves less is at rest
_AT_REST = 5e-3  # rad or m: a joint at rest's positions spread no more; a wider one went to another pose


@dataclass(frozen=True, eq=False, repr=False)
class ShortMotion(Brief):
    """Recordings of a short motion, friction free in each, and what they show of the ten.

    Method 3, (29), where the torque without payload was subtracted; else method 1, (22) and (23), with a robot
    that was identified earlier.
    """

    robot: Robot
    base: BaseParameters
    source: Source
    joints: tuple[int, ...]  # numbers of those that move; the rows of the others are left out
    # Of each recording with payload: the robot's base parameters (none where the unloaded torque was subtracted),
    # what is free in it, waves of ``ripple`` among that, and ``PAYLOAD``, in blocks of time.
    runs: tuple[Equations, ...]
    held: HeldFriction  # the same in all recordings
    torque_rms: Array  # of each joint's torque with payload in the rows used [N·m or N], (n,)
    known: Estimate | None = None  # the robot, where no torque was subtracted
    settings: Settings = DEFAULTS
    scale: KnownMass | None = None  # the payload was weighed; counts only where torques do not show the mass
    ripple: tuple[Wave, ...] = ()

    def __post_init__(self) -> None:
        """Refuse another model's robot."""
        check_known(self.robot, self.base, self.known)

    @cached_property
    def loaded(self) -> Equations:
        """Join the equations less all that is free in each recording, its blocks of time among them."""
        return merged(map(self.held.friction_free, self.runs))

    @property
    def method(self) -> int:
        """Number of the paper's method."""
        return 1 if self.known is not None else 3

    @property
    def robot_estimate(self) -> Estimate | None:
        """Robot's own parameters, where they are known."""
        return self.known

    @property
    def inflation(self) -> tuple[float, ...]:
        """Inflation of variances by the memory of each joint's errors under load."""
        return tuple(self.held.memory.tolist())

    @property
    def corrected(self) -> bool:
        """True if a robot known earlier is corrected by these recordings: its friction is of another day."""
        return self.known is not None and bool(self.held.held)

    @cached_property
    def visibility(self) -> PayloadVisibility:
        """Visibility of the payload in all recordings together."""
        factors = in_payload_frame(self.robot, self.loaded).select(PAYLOAD).factors
        return visibility_of(np.vstack(factors)[:, :-1], self.joints)

    def posed(self, wanted: Sequence[str] | None = None) -> LinearProblem:
        """Pose (29): Y_T - Y_wL = W_L chi_L, or (23): Y_T - W chi = W_L chi_L.

        Wanted: by default those of chi_L that stand for all that is visible. Fixed: the values of friction's prior;
        for (29) the difference of the paths, for (23) chi, whose errors weigh too much here for the formula's
        covariance. Soft prior: chi, where friction has one.
        """
        wanted = tuple(wanted or (PAYLOAD[k] for k in self.visibility.base.chosen))

        def shown(equations: Equations) -> Equations:
            columns = [name for name in equations.columns if name in wanted or name not in PAYLOAD]
            return in_payload_frame(self.robot, equations).select(columns)

        equations, prior = shown(self.loaded), None
        fixed: tuple[Known, ...] = (self.held.known,)
        if self.known is None:
            fixed += known_path(equations.columns, self.robot.n)
        elif self.corrected:
            prior = prior_of(self.known, self.inflation, self.loaded)
        else:
            robot = stored_robot(self.known)
            fixed = (robot._replace(covariance=robot.lasting), *fixed)
        parts = tuple(map(shown, self.without_each))
        # Against the robot's torque the payload's own is what the joints of a short motion are compared by.
        return LinearProblem(equations, wanted, fixed, prior=prior, own_torque=True, parts=parts)

    @cached_property
    def without_each(self) -> tuple[Equations, ...]:
        """Leave out each block of time of ``loaded``."""
        runs, left = [replace(self.held.friction_free(run), shared={}) for run in self.runs], list[Equations]()
        for k, run in enumerate(self.runs):
            others = [*runs[:k], *runs[k + 1 :]]
            if len(run.blocks) > 1:
                parts = map(self.held.friction_free, run.without_each())
                left += [merged([*others, part]) for part in parts]
            elif others:
                left.append(merged(others))
        return tuple(left)

    @property
    def left_out(self) -> tuple[tuple[tuple[int, int], ...], ...]:
        """Blocks of time that are left out in turn, none with them, as one group."""
        check_blocks(len(self.without_each))
        return (tuple((b, -1) for b in range(len(self.without_each))),)

    @property
    def block_length(self) -> float:
        """Shortest length of a block [s], unless a whole recording is shorter."""
        return max(run.block_length for run in self.runs)

    @property
    def needed_scale(self) -> KnownMass | None:
        """Scale, where torques do not show the mass; else it takes no part in the free estimate."""
        check_mass_visible(self.visibility, self.scale is not None, "by this motion")
        return None if self.visibility.mass_visible else self.scale

    def resolved(self, estimate: Estimate) -> Estimate:
        """Determine parameters from those posed; a ``needed_scale`` makes others follow from sums."""
        scale = self.needed_scale
        indices, A, by_mass = self.visibility.resolved(scale is not None)
        mass, variance = (scale.mass, scale.sigma**2) if scale is not None else (0.0, 0.0)
        payload = estimate.mapped(A, [PAYLOAD[k] for k in indices], by_mass * mass)
        shared, robust = variance * np.outer(by_mass, by_mass), payload.robust
        if robust is not None:
            robust = replace(robust, covariance=robust.covariance + shared)
        return replace(payload, covariance=payload.covariance + shared, robust=robust)


def known_robot_weighing(
    robot: Robot, loaded: Sequence[Recording], known: Estimate, settings: Settings = DEFAULTS
) -> ShortMotion:
    """Weigh by torques less those of a robot identified earlier, (22)-(23); else as ``difference_weighing``."""
    processing, progress = settings.processing_of(robot), settings.progress
    robot = without_dead(robot.of_parameters(known.names), loaded)
    check_recordings(robot, loaded)
    progress("base parameters")
    known = measured_part(known, robot)
    base = base_parameters(robot)
    measured = filtered(loaded, processing, progress)
    moving = moving_joints(measured, processing, settings.joints, robot)
    rows = [
        Used(data, telling_rows(data.motion, moving, processing), processing.thinning(data.motion.rate))
        for data in (at_rest(data, moving) for data in measured)
    ]
    rms = _torque_rms(loaded, rows)
    observer = observer_of(robot, base, settings.friction_change > 0.0)
    (_, observations), _ = under_own_load(observer, rows, known.values)
    k, changes = len(known.values), friction_changes(known, [1.0] * robot.n, settings.friction_change)
    payload_only = [  # less the torque of the robot, whose columns come first
        Observation.of(one.columns[k:], [W[:, k:] for W in one.W], one.errors(known.values), one.t, one.bandwidth)
        for one in observations
    ]
    own = {name: one.sigma for name, one in changes.items() if parameter_kind(name) in ("FS", "FV", "OFF")}
    source, held = (
        Source(tuple(loaded), (), processing, rate=measured[0].motion.rate),
        friction_prior(payload_only, own),
    )
    # Of a single recording the robot's own ripple is what would be found: it takes weight along.
    return ShortMotion(robot, base, source, moving, _runs(observations), held, rms, known, settings)


def difference_weighing(
    robot: Robot, loaded: Sequence[Recording], unloaded: Sequence[Recording], settings: Settings = DEFAULTS
) -> ShortMotion:
    """Weigh by torque differences (29) on one and the same motion.

    Args:
        loaded: recordings of the motion with the payload.
        unloaded: without it; one for all, or one for each of ``loaded`` in the same order.
    """
    processing, progress = settings.processing_of(robot), settings.progress
    robot = without_dead(robot, [*loaded, *unloaded])
    check_recordings(robot, [*loaded, *unloaded])
    check_lengths([*loaded, *unloaded], processing)
    check_apart(loaded, unloaded)
    if len(unloaded) not in (1, len(loaded)):
        raise InputError(
            f"{len(unloaded)} recordings without and {len(loaded)} with payload: give one without for all, or one "
            "for each in the same order"
        )
    partners = list(unloaded) * (len(loaded) if len(unloaded) == 1 else 1)
    together = each(list(zip(partners, loaded, strict=True)), lambda pair: f"aligning {pair[1].source}", progress)
    pairs = [aligned(a, b, grid_rate(b, processing), processing.max_mismatch) for a, b in together]
    measured = [(measurement(p.unloaded, processing), measurement(p.loaded, processing)) for p in pairs]
    moving = moving_joints([under_load for _, under_load in measured], processing, settings.joints, robot)
    rows = list[list[Used]]()
    for both in measured:
        # The filter's error at cut ends is alike in both, and a short motion needs its ends.
        still = [at_rest(data, moving) for data in both]
        keep = np.all([telling_rows(one.motion, moving, processing, ends=True) for one in still], axis=0)
        rows.append([Used(one, keep, processing.thinning(one.motion.rate)) for one in still])
    rms = _torque_rms([pair.loaded for pair in pairs], [under_load for _, under_load in rows])
    progress("the robot without payload")
    free = robot.with_offsets(True)
    whole, observer = Observer(free, base_parameters(free).columns), observer_of(robot, None)
    without_payload = merged(reduced(whole.observe_rows(*bare)) for bare, _ in rows)
    own, resting = robot_of(without_payload), [j for j in range(robot.n) if j + 1 not in moving]
    observations, ripple = list[Observation](), list[Wave]()
    for pair, ((without, *_), used) in zip(pairs, rows, strict=True):
        # No motion shows how torques change with a joint at rest, so that it stays where it was before.
        motion, q = used.data.motion, np.array(used.data.motion.q)
        q[:, resting] = without.motion.q[:, resting]
        path = whole.torques(Motion(motion.t, q, motion.qd, motion.qdd), own) - whole.torques(without.motion, own)
        used = used._replace(data=torque_change(robot, without, used.data, path))
        plain = observer.observe_rows(*used)
        names, dense = plain.columns, plain.W
        waves, columns = ripple_of(pair.loaded.source, [W[:, :-1] for W in dense], plain, used)
        if waves:  # free beside the payload
            names = (*names, *(f"{FREE}{k}" for k in range(columns[0].shape[1])))
            W = [np.column_stack(both) for both in zip(dense, columns, strict=True)]
            plain = Observation.of(names, W, plain.torques, plain.t, plain.bandwidth, plain.layout.motors)
        observations.append(plain)
        ripple += waves
    source = Source(tuple(loaded), tuple(unloaded), processing, tuple(pairs), rate=measured[0][1].motion.rate)
    base, held = base_parameters(robot), offset_prior(observations, coulomb_friction(without_payload))
    problem = ShortMotion(robot, base, source, moving, _runs(observations), held, rms, settings=settings)
    return replace(problem, ripple=tuple(ripple))


def observer_of(robot: Robot, base: BaseParameters | None, frees: bool = True) -> Observer:
    """Make the observer of [W, free columns, W_L]; of torque differences [free columns, W_L, ``PATH``]."""
    free = robot.with_offsets(True)
    own, path = (base.columns, ()) if base is not None else ((), (PATH,))
    friction = (*friction_columns(robot), *(name for name in own if parameter_kind(name) == "FV")) if frees else ()
    # FA gives way to offsets, which rows of a moving joint do not tell from it.
    known = (name.replace("FA", "OFF") if parameter_kind(name) == "FA" else name for name in own)
    columns = (*known, *friction, *payload_columns(free), *path)
    return Observer(free, columns, (*own, *(f"{FREE}{name}" for name in friction), *PAYLOAD, *path))


def _runs(observations: Sequence[Observation]) -> tuple[Equations, ...]:
    """Cut each recording's equations in blocks as long as the memory of all of them asks for."""
    rest = [one.eliminate(free_columns(one.columns)) for one in observations]
    length = block_length([remembered([one], reduced(one)) for one in rest])
    return tuple(in_blocks(reduced(one), [one], [block_edges(one, length)], length) for one in observations)


def _torque_rms(loaded: Sequence[Recording], rows: Sequence[Used]) -> Array:
    """Root mean square torque of each joint over the rows that are used; 0 where there are none."""
    for recording, used in zip(loaded, rows, strict=True):
        if not used.keep.any():
            raise InputError(f"{recording.source}: no joint moves fast enough: nothing can be compared")
    squares, keep = np.vstack([used.data.torque**2 for used in rows]), np.vstack([used.keep for used in rows])
    return np.asarray(np.sqrt(np.where(keep, squares, 0.0).sum(axis=0) / np.maximum(keep.sum(axis=0), 1)))


def moving_joints(
    measured: Sequence[Measurement], processing: Processing, joints: Sequence[int] | None, robot: Robot
) -> tuple[int, ...]:
    """Find the joints that move, or check those asked for; one that changes its pose between motions is at rest."""
    motions = [data.motion for data in measured]
    fast = np.vstack([np.abs(motion.qd[moving_parts(motion, processing.still_speed)]) > SLOW for motion in motions])
    moving = tuple(int(j) + 1 for j in np.flatnonzero(fast.mean(axis=0) > _LEAST)) if len(fast) else ()
    if not moving:
        raise InputError("no joint moves: record the short motion that 'dynident near' gives")
    idle = sorted(set(joints or ()) - set(moving))
    if idle:
        raise InputError(
            f"joint {', '.join(map(str, idle))} of {robot.name} hardly moves in the recordings; those that "
            f"move are {', '.join(map(str, moving))}: correct --joints"
        )
    return moving if joints is None else tuple(sorted(joints))


def at_rest(data: Measurement, moving: Sequence[int]) -> Measurement:
    """Set joints at rest, unless they go to another pose, exactly at rest: what encoders flicker is no motion."""
    q, qd, qdd = (np.array(x) for x in (data.motion.q, data.motion.qd, data.motion.qdd))
    for j in range(data.motion.n):
        if j + 1 not in moving and np.ptp(q[:, j]) < _AT_REST:
            q[:, j], qd[:, j], qdd[:, j] = q[:, j].mean(), 0.0, 0.0
    return Measurement(Motion(data.motion.t, q, qd, qdd), data.torque)


def telling_rows(motion: Motion, moving: Sequence[int], processing: Processing, ends: bool = False) -> Mask:
    """Mark rows that say something, N x n: of a moving joint, fast enough that its friction's sign is known.

    With ``ends`` also those where a recording was cut in full motion, which ``inner_samples`` leaves out.
    """
    speed = np.abs(motion.qd)
    whole = moving_parts(motion, processing.still_speed) if ends else inner_samples(motion, processing)
    least = np.maximum(least_speed(speed[whole].max(axis=0, initial=0.0), processing), SLOW)
    keep: Mask = (speed >= least) & whole[:, None]
    keep[:, [j for j in range(motion.n) if j + 1 not in moving]] = False
    return keep
