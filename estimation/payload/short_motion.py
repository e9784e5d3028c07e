"""A payload moved by some joints near a pose: friction is free in each recording, not all ten need be visible."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...common.arrays import Array
from ...common.brief import Brief
from ...common.errors import InputError
from ...model import BaseParameters, Motion, Processing, Robot
from ...model.motion import Measurement
from ...model.visibility import PayloadVisibility, visibility_of
from ..equations.equations import PAYLOAD, Equations, merged
from ..fit.estimate import Estimate
from ..fit.linear_problem import Known, LinearProblem
from ..possible.constraints import KnownMass
from ..signals.alignment import AlignedPair
from ..signals.rows import Mask, inner_samples, least_speed, moving_parts
from .constant_torques import FREE, HeldFriction
from .long_motion import Source, check_blocks, check_known, known_robot, prior_of
from .result import in_payload_frame
from .ripple import Wave
from .under_load import known_path

SLOW = 0.03
"""Speed [rad/s or m/s] of a joint below which rows are not used; the sign of its friction is not sure there."""
_LEAST = 0.1  # of the moving time: a joint that moves less is at rest
_AT_REST = 5e-3  # rad or m: a joint at rest's positions spread no more; a wider one went to another pose


@dataclass(frozen=True, eq=False, repr=False)
class Run(Brief):
    """Recording with payload, reduced.

    Attributes:
        source: of the recording with payload.
        equations: in the robot's base parameters (none where the unloaded torque was subtracted), what is free in
            this recording, and ``PAYLOAD``; in blocks of time.
        ripple: waves that are estimated with the payload.
    """

    source: str
    equations: Equations
    ripple: tuple[Wave, ...] = ()

    @cached_property
    def frictional(self) -> Equations:
        """Restore friction as it was: only robot and payload are separated."""
        return self.equations.select([name for name in self.equations.columns if not name.startswith(FREE)])


@dataclass(frozen=True, eq=False, repr=False)
class ShortMotion(Brief):
    """Recordings of a short motion, friction free in each, and what they show of the ten.

    Method 3, (29), where the torque without payload was subtracted; else method 1, (22) and (23), with a robot
    that was identified earlier.

    Attributes:
        base: the robot's base parameters.
        source: the recordings themselves.
        joints: numbers of the joints that move; the rows of the others are left out.
        runs: one a recording with payload.
        held: prior of constant torques and friction, the same in all recordings.
        torque_rms: root mean square of each joint's torque with payload in the rows used [N·m or N], shape (n,).
        known: the robot, where no torque was subtracted.
    """

    robot: Robot
    base: BaseParameters
    source: Source
    joints: tuple[int, ...]
    runs: tuple[Run, ...]
    held: HeldFriction
    torque_rms: Array
    known: Estimate | None = None

    def __post_init__(self) -> None:
        """Refuse another model's robot."""
        if self.known is not None:
            check_known(self.robot, self.base, self.known)

    @cached_property
    def loaded(self) -> Equations:
        """Join the equations less all that is free in each recording, its blocks of time among them."""
        return merged(self.held.friction_free(run.equations) for run in self.runs)

    @property
    def method(self) -> int:
        """Number of the paper's method."""
        return 1 if self.known is not None else 3

    @property
    def robot_estimate(self) -> Estimate | None:
        """Robot's own parameters, where they are known."""
        return self.known

    @property
    def pairs(self) -> tuple[AlignedPair, ...]:
        """Alignment of recordings with and without payload."""
        return self.source.compared

    @property
    def inflation(self) -> tuple[float, ...]:
        """Inflation of variances by the memory of each joint's errors under load."""
        return tuple(self.held.memory.tolist())

    @property
    def corrected(self) -> bool:
        """True if a robot known earlier is corrected by these recordings: its friction is of another day."""
        return self.known is not None and bool(self.held.held)

    @property
    def robot_prior(self) -> Known:
        """Prior of a robot known earlier, by the covariance that its errors really have."""
        assert self.known is not None
        return prior_of(self.known, self.inflation, self.loaded)

    @cached_property
    def visibility(self) -> PayloadVisibility:
        """Visibility of the payload in all recordings together."""
        factors = in_payload_frame(self.robot, self.loaded).select(PAYLOAD).factors
        return visibility_of(np.vstack(factors)[:, :-1], self.joints)

    def posed(self, wanted: Sequence[str] | None = None) -> LinearProblem:
        """Pose (29): Y_T - Y_wL = W_L chi_L, or (23): Y_T - W chi = W_L chi_L.

        Wanted: what is visible of chi_L. Fixed: the values of friction's prior; for (29) the difference of the
        paths, for (23) chi, whose errors weigh too much here for the formula's covariance. Soft prior: chi, where
        friction has one.

        Args:
            wanted: of the ten; by default those that stand for all that can be seen.
        """
        wanted = tuple(wanted or (PAYLOAD[k] for k in self.visibility.base.chosen))

        def shown(equations: Equations) -> Equations:
            columns = [name for name in equations.columns if name in wanted or name not in PAYLOAD]
            return in_payload_frame(self.robot, equations).select(columns)

        equations = shown(self.loaded)
        fixed: tuple[Known, ...] = (self.held.known,)
        if self.known is None:
            fixed = (*fixed, *known_path(equations.columns, self.robot.n))
        elif not self.corrected:
            robot = known_robot(self.known)
            fixed = (robot._replace(covariance=robot.lasting), *fixed)
        return LinearProblem(
            equations,
            wanted,
            fixed,
            prior=self.robot_prior if self.corrected else None,
            # Against the robot's torque the payload's own is what the joints of a short motion are compared by.
            own_torque=True,
            parts=tuple(map(shown, self.without_each)),
        )

    @cached_property
    def without_each(self) -> tuple[Equations, ...]:
        """Leave out each block of time of ``loaded``; nothing shared is kept."""
        runs, left = [self.held.friction_free(run.equations) for run in self.runs], list[Equations]()
        runs = [replace(run, shared=()) for run in runs]
        for k, run in enumerate(self.runs):
            others = [*runs[:k], *runs[k + 1 :]]
            if len(run.equations.blocks) > 1:
                parts = map(self.held.friction_free, run.equations.without_each())
                left += [merged([*others, part]) for part in parts]
            elif others:
                left.append(merged(others))
        return tuple(left)

    @property
    def left_out(self) -> tuple[tuple[tuple[int, int], ...], ...]:
        """Blocks of time that are left out in turn, none with them, as one group.

        Raises:
            InputError: if there are fewer than two blocks.
        """
        check_blocks(len(self.without_each))
        return (tuple((b, -1) for b in range(len(self.without_each))),)

    @property
    def block_length(self) -> float:
        """Shortest length of a block [s], unless a whole recording is shorter."""
        return max(run.equations.blocks.length for run in self.runs)

    def needed(self, scale: KnownMass | None) -> KnownMass | None:
        """Scale that is needed where torques do not show the mass; else it takes no part in the free estimate.

        Raises:
            InputError: "mass not visible" if neither shows it.
        """
        if self.visibility.mass_visible:
            return None
        if scale is None:
            joints = ", ".join(map(str, self.visibility.joints))
            sums = self.visibility.combination("M")
            why = f"only in {sums}" if sums else "not at all"
            raise InputError(
                f"mass not visible: the torques of joint {joints} show it {why}; move another joint as well, or "
                "weigh the payload and give --mass KG+-KG"
            )
        return scale

    def resolved(self, estimate: Estimate, scale: KnownMass | None) -> Estimate:
        """Determine parameters from those posed; a ``needed`` scale makes others follow from sums.

        Nothing that the torques leave open is filled in.
        """
        indices, A, by_mass = self.visibility.resolved(scale is not None)
        mass, variance = (scale.mass, scale.sigma**2) if scale is not None else (0.0, 0.0)
        payload = estimate.mapped(A, [PAYLOAD[k] for k in indices], by_mass * mass)
        shared = variance * np.outer(by_mass, by_mass)
        robust = payload.robust
        if robust is not None:
            robust = replace(robust, covariance=robust.covariance + shared)
        return replace(payload, covariance=payload.covariance + shared, robust=robust)


def moving_joints(
    measured: Sequence[Measurement], processing: Processing, joints: Sequence[int] | None, robot: Robot
) -> tuple[int, ...]:
    """Find the joints that move, or check those asked for; one that changes its pose between motions is at rest.

    Args:
        measured: of one session.
        joints: asked for; all that move by default.

    Raises:
        InputError: if none moves, or one asked for does not.
    """
    motions = [data.motion for data in measured]
    fast = np.vstack([np.abs(motion.qd[moving_parts(motion, processing.still_speed)]) > SLOW for motion in motions])
    moving = tuple(int(j) + 1 for j in np.flatnonzero(fast.mean(axis=0) > _LEAST)) if len(fast) else ()
    if not moving:
        raise InputError("no joint moves: record the short motion that 'dynident near' gives")
    idle = sorted(set(joints or ()) - set(moving))
    if idle:
        raise InputError(
            f"joint {', '.join(map(str, idle))} of {robot.name} does not move in the recordings, or hardly; joint "
            f"{', '.join(map(str, moving))} does: correct --joints"
        )
    return moving if joints is None else tuple(sorted(joints))


def at_rest(data: Measurement, moving: Sequence[int]) -> Measurement:
    """Set joints at rest exactly at rest: what their encoders flicker is no motion.

    A joint at rest that goes to another pose on the way keeps what was measured.
    """
    motion = data.motion
    q, qd, qdd = (np.array(x) for x in (motion.q, motion.qd, motion.qdd))
    for j in range(motion.n):
        if j + 1 not in moving and np.ptp(q[:, j]) < _AT_REST:
            q[:, j], qd[:, j], qdd[:, j] = q[:, j].mean(), 0.0, 0.0
    return Measurement(Motion(motion.t, q, qd, qdd), data.torque)


def telling_rows(motion: Motion, moving: Sequence[int], processing: Processing, ends: bool = False) -> Mask:
    """Mark rows that say something, N x n: of a moving joint, fast enough that its friction's sign is known.

    Args:
        moving: numbers of the joints that move.
        ends: keep also the ends at which a recording was cut in full motion, which ``inner_samples`` leaves out.
    """
    speed = np.abs(motion.qd)
    whole = moving_parts(motion, processing.still_speed) if ends else inner_samples(motion, processing)
    least = np.maximum(least_speed(speed[whole].max(axis=0, initial=0.0), processing), SLOW)
    keep: Mask = (speed >= least) & whole[:, None]
    keep[:, [j for j in range(motion.n) if j + 1 not in moving]] = False
    return keep
