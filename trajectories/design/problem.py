"""The design problem: everything that gives a criterion, its limits and their slopes for a vector x.

It is built from a robot, the shape of its motion, a goal and what stands in the way.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from msgspec import structs
from numpy.typing import NDArray

from ...common.arrays import Array
from ...common.brief import Brief
from ...common.errors import InputError
from ...model import InertialParameters, Robot, base_parameters, standard_columns
from ...model.base.parameters import BaseParameters
from ...model.base.rank import base_parameters_of
from ...model.regressors import payload_columns
from ..motions.family import Family, JointBounds, Samples
from ..motions.fourier import NearShape
from ..motions.via_points import ViaPointShape
from .criterion import Criterion
from .goal import Goal, NearGoal, Shape
from .information import SPRING, RegressorKernel, regressor_kernel
from .limits import (
    Limit,
    LimitCheck,
    Penalty,
    State,
    check,
    duration_limit,
    slow_limit,
    state_limits,
    torque_limit,
)
from .payloads import PayloadSet, payload_limit
from .scene import Capsule, Scene, clearance

_WRIST = 3  # links before the flange that the ball of the payloads may overlap


@dataclass(frozen=True, eq=False, repr=False)
class DesignProblem(Brief):
    """Problem that ``solve_design`` solves; made by ``build_design``.

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
        """Refuse reference values, noise or earlier recordings that do not fit the robot."""
        _ = self.criterion, self.noise, self.earlier

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Parameters that will be estimated, c."""
        return self.goal.names(self.robot)

    @cached_property
    def criterion(self) -> Criterion:
        """The goal's criterion in the order of ``names``."""
        goal, names = self.goal, self.names
        interest = None if goal.interest is None else [names.index(name) for name in goal.interest]
        if goal.criterion != "a" or goal.reference is None:
            return Criterion(goal.criterion, None, interest)
        values = goal.reference
        missing = [name for name in goal.interest or names if not values.get(name, 0.0)]
        if missing:
            raise InputError(f"criterion a needs a reference value other than zero for {', '.join(missing[:6])}")
        return Criterion("a", np.array([values.get(name, 0.0) or 1.0 for name in names]), interest)

    @cached_property
    def places(self) -> NDArray[np.intp]:
        """Indices of the regressor's columns that are ``names``."""
        return np.array([self.kernel.columns.index(name) for name in self.names])

    @cached_property
    def noise(self) -> Array:
        """Standard deviation of the torques per joint [N·m or N], shape (n,)."""
        robot, given = self.robot, self.goal.noise
        noise = np.ones(robot.n) if given is None else np.asarray(given, dtype=float)
        if noise.shape != (robot.n,) or not (noise > 0.0).all() or not np.isfinite(noise).any():
            raise InputError(f"torque noise: robot {robot.name!r} needs {robot.n} positive numbers")
        return noise

    @cached_property
    def earlier(self) -> Array:
        """R of the earlier recordings, in the criterion's weights, k x c; k = 0 without."""
        known = self.goal.earlier
        if known is None:
            return np.zeros((0, len(self.names)))
        unmatched = set(known.columns) ^ set(self.names)
        if unmatched or np.shape(known.factor)[-1] != len(known.columns):
            raise InputError(
                "the earlier recordings' factor does not fit the design's columns: "
                f"{', '.join(sorted(unmatched)[:6])} stand on one side only; select the same columns"
            )
        return np.asarray(known.factor)[:, [known.columns.index(name) for name in self.names]]

    def of_kind(self, *kinds: str) -> tuple[Limit, ...]:
        """Limits of some kinds ("torque", "clearance")."""
        return tuple(limit for limit in self.limits if limit.kind in kinds)

    @property
    def torque_limited(self) -> bool:
        """True if a motion has to keep torque limits."""
        return bool(self.of_kind("torque"))

    def with_torque_share(self, part: float) -> "DesignProblem":
        """Pose the same problem with only a part of the torque limits."""
        limits = (
            replace(limit, low=part * limit.low, high=part * limit.high) if limit.kind == "torque" else limit
            for limit in self.limits
        )
        return replace(self, limits=tuple(limits))

    def with_slow_torques(self, speed: float) -> "DesignProblem":
        """Require besides that the same way keeps the torque limits at a fraction of the speed."""
        slow = (slow_limit(self.kernel, limit, speed) for limit in self.of_kind("torque"))
        return replace(self, limits=(*self.limits, *slow))

    def exact(self, samples: Samples) -> State:
        """Evaluate samples and regressor with the exact sign."""
        return State(samples, self.kernel.entries(samples, 0.0))

    def state(self, x: Array, width: float, finer: int = 1) -> State:
        """Evaluate samples and regressor; ``width`` 0 for the exact sign."""
        samples = self.family.sample(x, finer)
        return State(samples, self.kernel.entries(samples, width), width)

    def at_rest(self, poses: Array) -> State:
        """Evaluate the arm held at poses (N, n)."""
        still = np.zeros_like(poses)
        return self.exact(Samples(np.ones(len(poses)), poses, still, still))

    def clear(self, poses: Array) -> bool:
        """True if all poses (N, n) keep clear of obstacles and of each other's bodies."""
        return all(nearest.room >= 0.0 for nearest in self.clearances(poses))

    def clearances(self, poses: Array) -> list[LimitCheck]:
        """Check poses (N, n) against what is in the scene."""
        return [check(limit, self.at_rest(poses)) for limit in self.of_kind("clearance")]

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
        """Information W' diag(w) W of the parameters, c x c, earlier recordings included; ``weights`` (n, N)."""
        return self.kernel.gram(entries, weights)[np.ix_(self.places, self.places)] + self.earlier.T @ self.earlier

    def evaluate(self, x: Array, order: float, width: float, limits: Penalty | None = None) -> tuple[float, Array]:
        """Evaluate criterion, with the terms of the limits if given, and the exact gradient in x.

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
        weights = self.row_weights(samples, self.criterion.rule.weighted)
        own = np.ix_(self.places, self.places)
        value, part = self.criterion(self.information(state.entries, weights), order)
        if not np.isfinite(value):
            return np.inf, np.zeros(len(x))
        M = np.zeros((len(self.kernel.columns),) * 2)
        M[own] = part
        # Weights are times over their sum, so that their slopes lose the mean.
        seed, by_weight = self.kernel.gram_slope(state.entries, weights, M)
        by_time = np.einsum("jk,jk->k", by_weight, weights) / samples.weight
        slopes = State(Samples.zeros(samples), seed)
        slopes.samples.weight[...] = by_time - (by_time @ samples.weight) / samples.weight.sum()
        if limits is not None:
            value += limits(state, slopes)
        return value, self._pulled_back(x, width, state, slopes)

    def trespass(self, x: Array, width: float, limits: Penalty) -> tuple[float, Array]:
        """Evaluate the terms of the limits alone, with their gradient: zero where all are met."""
        state = self.state(x, width)
        slopes = State(Samples.zeros(state.samples), np.zeros_like(state.entries))
        value = limits(state, slopes)
        return value, self._pulled_back(x, width, state, slopes)

    def _pulled_back(self, x: Array, width: float, state: State, slopes: State) -> Array:
        """Compute the gradient in x: one adjoint of the regressor, then the family's."""
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


@dataclass(frozen=True)
class Loads:
    """Loads: parameters that torque limits are computed from.

    Attributes:
        parameters: standard or base parameters of the robot by name.
        heaviest: the heaviest payload expected, in the last link's frame; the limits then hold without and
            with it. A set: they hold for each of its bodies, and without any.
        covariance: of ``parameters`` in their order; None where they are taken as exact. It counts for a set, by
            two standard deviations of the robot's own torque.
        margin: fraction of the torque limits that stays free.
    """

    parameters: Mapping[str, float]
    heaviest: InertialParameters | PayloadSet | None = None
    covariance: Array | None = None
    margin: float = 0.0

    def __post_init__(self) -> None:
        """Refuse a margin that leaves nothing."""
        if not 0.0 <= self.margin < 1.0:
            raise InputError(f"a torque margin of {self.margin:g}: give a share of the limits from 0 to below 1")


def build_design(
    robot: Robot,
    shape: Shape | None = None,
    goal: Goal | NearGoal | None = None,
    *,
    bounds: JointBounds | None = None,
    loads: Loads | None = None,
    scene: Scene | None = None,
) -> DesignProblem:
    """Build the problem; ``solve_design`` solves it.

    Args:
        shape: of the motion; 14 via points if None.
        goal: what is to be learnt; the information about all base parameters if None.
        bounds: limits of the joints; the description's if None.
        loads: parameters for the torque limits; the description's if None. Unused without torque limits.
        scene: obstacles, and the bodies that must keep clear of them and of each other.

    Raises:
        InputError: if something is missing or does not fit; if the parameters cannot be told apart.
    """
    shape, goal, bounds = shape or ViaPointShape(), goal or Goal(), bounds or JointBounds.of(robot)
    family = shape.family(robot, bounds)
    if isinstance(goal, NearGoal):
        goal = goal.with_friction(robot, shape, family)
    model, base = goal.model(robot), base_parameters(robot) if np.isfinite(bounds.torque).any() else None
    names, around, payloads = goal.names(robot), scene, None
    if loads is not None and isinstance(loads.heaviest, PayloadSet):
        payloads = loads.heaviest
        names += payload_columns(robot)
        if scene is not None:
            # The ball that holds the payloads: clear of all surfaces, and of bodies below the wrist.
            x, y, z = payloads.centre.tolist()
            ball = Capsule("payload within bounds", robot.n, payloads.radius, (x, y, z))
            pairs = ((ball.name, body.name) for body in scene.bodies if body.link <= robot.n - _WRIST)
            around = structs.replace(scene, bodies=(*scene.bodies, ball), pairs=(*scene.pairs, *pairs))
    # Columns stand in the robot's order, so that different goals share compiled code.
    needed = {*names, *(base.columns if base is not None else ())}
    columns = tuple(name for name in standard_columns(model) if name in needed)
    spring = (SPRING,) if base is not None and robot.spring is not None else ()
    kernel = regressor_kernel(model, (*columns, *spring))
    longest = shape.longest if isinstance(shape, ViaPointShape) else None
    start = None if isinstance(shape, NearShape) else shape.start
    limits = (
        *state_limits(bounds, family.reach),
        *(
            _torque_limits(robot, base, kernel, bounds, loads or Loads(robot.parameters))
            if base is not None
            else ()
        ),
        *((duration_limit(longest),) if longest is not None else ()),
        *((clearance(robot, around),) if around is not None else ()),
    )
    problem = DesignProblem(model, bounds, family, goal, kernel, limits, payloads, around)
    for nearest in problem.clearances(np.array([start])) if start is not None else ():
        if nearest.room < 0.0:
            raise InputError(f"choose another start pose: {nearest} m")
    problem.require_full_rank(family.random(np.random.default_rng(0)))
    return problem


def _torque_limits(
    robot: Robot, base: BaseParameters, kernel: RegressorKernel, bounds: JointBounds, loads: Loads
) -> Iterator[Limit]:
    """Make the torque limits for each load."""
    known, torque = loads.parameters, (1.0 - loads.margin) * bounds.torque
    if all(name in known for name in base.standard):
        values = base.value(known)
    elif missing := [name for name in base.columns if name not in known]:
        raise InputError(
            f"torque limits need the parameters of robot {robot.name!r}: {', '.join(missing[:6])} "
            "are missing; identify the robot first, or leave torque limits out"
        )
    else:
        values = np.array([known[name] for name in base.columns])

    def by_column(chi: Array) -> Array:
        by_name = dict(zip(base.columns, chi, strict=True)) | {SPRING: -1.0}
        return np.array([by_name.get(name, 0.0) for name in kernel.columns])

    if isinstance(loads.heaviest, PayloadSet):
        root = np.zeros((len(kernel.columns), 0))
        if loads.covariance is not None:
            names = list(known)
            if not set(base.columns) <= set(names) or np.shape(loads.covariance) != (len(names),) * 2:
                raise InputError(
                    "a covariance of the torques' parameters must be that of all base parameters, in their order"
                )
            variances, V = np.linalg.eigh(loads.covariance)
            root = np.zeros((len(kernel.columns), len(names)))
            for name in base.columns:
                root[kernel.columns.index(name)] = (V * np.sqrt(np.maximum(variances, 0.0)))[names.index(name)]
        yield payload_limit(kernel, by_column(values), root, torque, loads.heaviest, payload_columns(robot))
        return
    cases = {"": values}
    if loads.heaviest is not None:
        change = base.effect_of(payload_columns(robot)) @ loads.heaviest.vector
        cases = {"without payload": values, "with the heaviest payload": values + change}
    for load, chi in cases.items():
        yield torque_limit(kernel, by_column(chi), torque, load)
