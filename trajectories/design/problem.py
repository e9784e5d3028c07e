"""The design problem: everything that gives a criterion, its limits and their slopes for a vector x."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import Robot
from ...model.base import base_parameters_of
from ..motions.bounds import JointBounds
from ..motions.samples import Family, Samples
from .criterion import Criterion
from .goal import Goal
from .information import RegressorKernel
from .limits import Limit, LimitCheck, Penalty, State, check, slow_limit
from .payloads import PayloadSet
from .scene import Scene


@dataclass(frozen=True, eq=False)
class DesignProblem:
    """What ``solve_design`` solves; made by ``build_design``.

    Attributes:
        robot, bounds: the robot and the limits of its joints.
        family: the motions among which to choose.
        goal: what is to be learnt.
        limits: what the motion has to keep.
        scene: what the motion keeps clear of, the ball of ``payloads`` included.
        payloads: the set for each body of which the torque limits hold, in the last link's frame.
    """

    robot: Robot
    bounds: JointBounds
    family: Family
    goal: Goal
    kernel: RegressorKernel
    limits: tuple[Limit, ...]
    payloads: PayloadSet | None = None
    scene: Scene | None = None

    def __post_init__(self) -> None:
        """Refuse a goal that does not fit the robot."""
        _ = self.criterion, self.noise, self.earlier

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Parameters that will be estimated, c."""
        return self.goal.names(self.robot)

    @cached_property
    def criterion(self) -> Criterion:
        """The goal's criterion in the order of ``names``."""
        return self.goal.measure(self.names)

    @cached_property
    def places(self) -> NDArray[np.intp]:
        """Columns of the regressor that are ``names``."""
        return np.array([self.kernel.columns.index(name) for name in self.names])

    @cached_property
    def noise(self) -> Array:
        """Standard deviation of the torques per joint [N·m or N], shape (n,)."""
        return self.goal.joint_noise(self.robot)

    @cached_property
    def earlier(self) -> Array:
        """R of earlier recordings, in the criterion's weights, k x c; k = 0 without."""
        return np.zeros((0, len(self.names))) if self.goal.earlier is None else self.goal.earlier.rows(self.names)

    @property
    def torque_limited(self) -> bool:
        """Whether a motion has to keep torque limits."""
        return any(limit.kind == "torque" for limit in self.limits)

    def with_torque_share(self, share: float) -> "DesignProblem":
        """Ask the same of a motion with only a share of the torque limits."""
        limits = (
            replace(limit, low=share * limit.low, high=share * limit.high) if limit.kind == "torque" else limit
            for limit in self.limits
        )
        return replace(self, limits=tuple(limits))

    def with_slow_torques(self, speed: float) -> "DesignProblem":
        """Ask besides that the same way keeps the torque limits at a fraction of the speed."""
        slow = (slow_limit(self.kernel, limit, speed) for limit in self.limits if limit.kind == "torque")
        return replace(self, limits=(*self.limits, *slow))

    def state(self, x: Array, width: float, finer: int = 1) -> State:
        """Samples and regressor; ``width`` 0 for the exact sign."""
        samples = self.family.sample(x, finer)
        return State(samples, self.kernel.entries(samples, width), width)

    def at_rest(self, poses: Array) -> State:
        """The arm held at poses (N, n)."""
        still = np.zeros_like(poses)
        samples = Samples(np.ones(len(poses)), poses, still, still)
        return State(samples, self.kernel.entries(samples, 0.0))

    def clear(self, poses: Array) -> bool:
        """Whether poses (N, n) keep clear of obstacles and of each other's bodies."""
        return all(nearest.room >= 0.0 for nearest in self.clearances(poses))

    def clearances(self, poses: Array) -> list[LimitCheck]:
        """How near poses (N, n) come to what is in the scene."""
        limits = [limit for limit in self.limits if limit.kind == "clearance"]
        state = self.at_rest(poses) if limits else None
        return [check(limit, state) for limit in limits if state is not None]

    def row_weights(self, samples: Samples, weighted: bool, duration: float | None = None) -> Array:
        """Weight of each row's square, (n, N): the number of independent recordings it stands for.

        Args:
            weighted: whether the joints' torque noise counts.
            duration: how long is recorded [s]; the goal's data length, or else 1 s, if None.
        """
        recorded = self.goal.rate * (duration or self.goal.data_length or 1.0)
        joints = 1.0 / self.noise**2 if weighted else np.ones(self.robot.n)
        return np.asarray(joints[:, None] * (samples.weight * (recorded / samples.weight.sum())))

    def information(self, entries: Array, weights: Array) -> Array:
        """G = W' diag(w) W of the parameters, c x c, with that of the earlier recordings; ``weights`` (n, N)."""
        return self.kernel.gram(entries, weights)[np.ix_(self.places, self.places)] + self.earlier.T @ self.earlier

    def evaluate(self, x: Array, order: float, width: float, limits: Penalty | None = None) -> tuple[float, Array]:
        """Criterion, with the terms of the limits if given, and the exact gradient in x.

        While optimising, information counts per second of motion, so that a longer motion is not better for its
        length alone.

        Args:
            x: the motion, shape (family.size,).
            order: of a condition number's surrogate.
            width: of the smoothed sign [rad/s or m/s], positive.
            limits: terms of the limits, as of an augmented Lagrangian.
        """
        state = self.state(x, width)
        samples = state.samples
        weights = self.row_weights(samples, self.criterion.weighted)
        own = np.ix_(self.places, self.places)
        value, part = self.criterion(self.information(state.entries, weights), order)
        if not np.isfinite(value):
            return np.inf, np.zeros(len(x))
        M = np.zeros((len(self.kernel.columns),) * 2)
        M[own] = part
        seed, by_weight = self.kernel.gram_slope(state.entries, weights, M)
        by_time = np.einsum("jk,jk->k", by_weight, weights) / samples.weight
        slopes = State(Samples.zeros(samples), seed)
        slopes.samples.weight[...] = by_time - (by_time @ samples.weight) / samples.weight.sum()
        if limits is not None:
            value += limits(state, slopes)
        return value, self._pulled_back(x, width, state, slopes)

    def trespass(self, x: Array, width: float, limits: Penalty) -> tuple[float, Array]:
        """Terms of the limits alone, with their gradient: zero where all are met."""
        state = self.state(x, width)
        slopes = State(Samples.zeros(state.samples), np.zeros_like(state.entries))
        value = limits(state, slopes)
        return value, self._pulled_back(x, width, state, slopes)

    def _pulled_back(self, x: Array, width: float, state: State, slopes: State) -> Array:
        """Gradient in x: one adjoint of the regressor, then the family's."""
        states = self.kernel.state_slope(state.samples, width, slopes.entries)
        for into, slope in zip(slopes.samples[1:], states, strict=True):
            into += slope
        return self.family.pullback(x, slopes.samples)

    def require_full_rank(self, x: Array) -> None:
        """Refuse parameters that no motion of the family tells apart, seen on a random one."""
        W = self.kernel.matrix(self.family.sample(x), 0.0)[:, self.places]
        W = np.vstack([W, self.earlier])
        if len(W) < W.shape[1]:
            raise InputError(f"{len(W)} equations cannot tell {W.shape[1]} parameters: use more samples")
        base = base_parameters_of(self.names, W)
        if len(base.chosen) == len(self.names):
            return
        texts = [f"{name} has no effect" for name in base.unidentifiable]
        for k in sorted(set(range(len(self.names))) - set(base.chosen)):
            with_it = [base.columns[i] for i in np.flatnonzero(np.abs(base.grouping[:, k]) > 1e-6)]
            if with_it:
                texts.append(f"{self.names[k]} acts only together with {', '.join(with_it)}")
        more = f"; and {len(texts) - 6} more" if len(texts) > 6 else ""
        raise InputError(
            f"these parameters cannot all be told apart (rank {len(base.chosen)} of {len(self.names)}): "
            f"{'; '.join(texts[:6])}{more}; leave some out, or give the motion more freedom"
        )
