"""The design problem: everything that gives a criterion, its limits and their slopes for a vector x.

It is built from a robot, the shape of its motion, a goal and what stands in the way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from msgspec import structs

from ...common import Array, Brief, Indices, InputError
from ...common.errors import listed
from ...model import Robot, base_parameters, standard_columns
from ...model.base import base_parameters_of
from ...model.drives import SPRING
from ...model.regressors import payload_columns
from ...model.stand_in import completed
from ..motions.family import JointBounds, Samples
from ..motions.fourier import NearShape
from ..motions.via_points import ViaPointShape
from .goal import CRITERIA, Criterion, Family, Goal, NearGoal, RegressorKernel, Shape, regressor_kernel
from .limits import Limit, Loads, PayloadSet, Penalty, check, slowed, state_limits, torque_limits, total_time
from .scene import Capsule, Scene, clearance, tubes

BALL = "payload within bounds"  # name of the body that stands for every payload within bounds
_WRIST = 3  # links before the flange that the ball of the payloads may overlap


@dataclass(frozen=True, eq=False, repr=False)
class DesignProblem(Brief):
    """Problem that ``solve_design`` solves; made by ``build_design``.

    Attributes:
        family: the motions among which to choose.
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
        _ = self.criterion, self.noise, self.earlier

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Parameters that will be estimated, c."""
        return self.goal.names(self.robot)

    @cached_property
    def criterion(self) -> Criterion:
        """The goal's criterion in the order of ``names``."""
        goal, names, values = self.goal, self.names, self.goal.reference or {}
        criterion = CRITERIA[goal.criterion]
        if goal.interest is not None:
            criterion = criterion._replace(interest=[names.index(name) for name in goal.interest])
        if goal.criterion != "a":
            return criterion
        if missing := [name for name in goal.interest or names if not values.get(name, 0.0)]:
            raise InputError(f"criterion a needs a reference value other than zero for {listed(missing)}")
        return criterion._replace(reference=np.array([values.get(name, 0.0) or 1.0 for name in names]))

    @cached_property
    def places(self) -> Indices:
        """Indices of the regressor's columns that are ``names``."""
        return np.array([self.kernel.columns.index(name) for name in self.names])

    @cached_property
    def noise(self) -> Array:
        """Standard deviation of the torques per joint [N·m or N], shape (n,); 1 where no limit tells it."""
        return self.goal.sigma(self.robot)

    @cached_property
    def earlier(self) -> Array:
        """R of the earlier recordings, in the criterion's weights, k x c; k = 0 without."""
        known = self.goal.earlier
        if known is None:
            return np.zeros((0, len(self.names)))
        unmatched = sorted(set(known.columns) ^ set(self.names))
        if unmatched or np.shape(known.factor)[-1] != len(known.columns):
            fault = f"the earlier recordings' factor does not fit the design's columns: {listed(unmatched)}"
            raise InputError(f"{fault} stand on one side only; select the same columns")
        return np.asarray(known.factor)[:, [known.columns.index(name) for name in self.names]]

    def of_kind(self, *kinds: str) -> tuple[Limit, ...]:
        """Limits of some kinds ("torque", "clearance")."""
        return tuple(limit for limit in self.limits if limit.kind in kinds)

    @property
    def torque_limited(self) -> bool:
        """True if a motion has to keep torque limits."""
        return bool(self.of_kind("torque"))

    def with_torque_share(self, part: float) -> DesignProblem:
        """Pose the same problem with only a part of the torque limits."""
        own = [replace(x, low=part * x.low, high=part * x.high) if x.kind == "torque" else x for x in self.limits]
        return replace(self, limits=tuple(own))

    def with_slow_torques(self, speed: float) -> DesignProblem:
        """Require besides that the same way keeps the torque limits at a fraction of the speed.

        What dynamic forces help to lift has to be held without them: a limit may be active in the slow run alone.
        """
        slow = []
        for limit in self.of_kind("torque"):
            name = f"{limit.name} at {100.0 * speed:g} % of the speed"
            slow.append(replace(limit, name=name, measure=partial(slowed, self.kernel, limit, speed)))
        return replace(self, limits=(*self.limits, *slow))

    def state(self, x: Array, width: float, finer: int = 1) -> Samples:
        """Evaluate samples and regressor; ``width`` 0 for the exact sign."""
        return self.kernel.state(self.family.sample(x, finer), width)

    def at_rest(self, poses: Array) -> Samples:
        """Evaluate the arm held at poses (N, n)."""
        return self.kernel.state(Samples.at_rest(poses))

    def clear(self, poses: Array) -> bool:
        """True if all poses (N, n) keep clear of obstacles and of each other's bodies."""
        return all(check(limit, self.at_rest(poses)).room >= 0.0 for limit in self.of_kind("clearance"))

    def row_weights(self, samples: Samples, weighted: bool) -> Array:
        """Weight of each row's square, (n, N): the number of independent recordings it stands for.

        ``weighted``: by the joints' torque noise too. Recorded is for the goal's data length, or else 1 s.
        """
        recorded = self.goal.single_rate * (self.goal.data_length or 1.0)
        joints = 1.0 / self.noise**2 if weighted else np.ones(self.robot.n)
        return np.asarray(joints[:, None] * (samples.weight * (recorded / samples.weight.sum())))

    def rows(self, state: Samples, weights: Array | float = 1.0) -> Array:
        """Rows of W for ``names`` on samples, (n N) x c, times the roots of ``weights``, (n, N)."""
        W = self.kernel.matrix(state)[:, :, self.places] * np.sqrt(weights)[..., None]
        return W.reshape(-1, len(self.names))

    def information(self, entries: Array, weights: Array) -> Array:
        """Information W' diag(w) W of the parameters, c x c, earlier recordings included; ``weights`` (n, N)."""
        return self.kernel.gram(entries, weights)[np.ix_(self.places, self.places)] + self.earlier.T @ self.earlier

    def evaluate(self, x: Array, width: float, terms: Sequence[Penalty]) -> tuple[float, Array]:
        """Sum of terms and its exact gradient in x; the sign is smoothed over ``width`` [rad/s or m/s]."""
        state, value = self.state(x, width), 0.0
        slopes = Samples(*map(np.zeros_like, state))
        for term in terms:
            value += term(state, slopes)
            if not np.isfinite(value):
                return np.inf, np.zeros(len(x))
        for into, slope in zip(slopes[1:4], self.kernel.state_slope(state, slopes.entries), strict=True):
            into += slope
        return value, self.family.pullback(x, slopes)

    def criterion_term(self, state: Samples, into: Samples, order: float) -> float:
        """Evaluate the criterion, by a surrogate of ``order``, of a state; its slopes are added to ``into``.

        Information counts per second of motion, so that a longer motion is not better for its length alone.
        """
        weight, own = state.weight, np.ix_(self.places, self.places)
        weights = self.row_weights(state, self.criterion.weighted)
        M = np.zeros((len(self.kernel.columns),) * 2)
        value, M[own] = self.criterion(self.information(state.entries, weights), order)
        if np.isfinite(value):
            by_weight = self.kernel.gram_slope(state.entries, weights, M, into.entries)
            # Weights are times over their sum, so that their slopes lose the mean.
            by_time = np.einsum("jk,jk->k", by_weight, weights) / weight
            into.weight[...] += by_time - (by_time @ weight) / weight.sum()
        return value

    def require_full_rank(self, x: Array) -> None:
        """Refuse parameters that no motion of the family tells apart, seen on a random one."""
        W = np.vstack([self.rows(self.kernel.state(self.family.sample(x))), self.earlier])
        if len(W) < W.shape[1]:
            raise InputError(f"{len(W)} equations cannot tell {W.shape[1]} parameters: use more samples")
        base = base_parameters_of(self.names, W)
        texts = [f"{name} has no effect" for name in base.unidentifiable]
        for k in sorted(set(range(len(self.names))) - set(base.chosen)):
            if with_it := [base.columns[i] for i in np.flatnonzero(np.abs(base.grouping[:, k]) > 1e-6)]:
                texts.append(f"{self.names[k]} acts only together with {', '.join(with_it)}")
        if len(base.chosen) == len(self.names):
            return
        more = f"; and {len(texts) - 6} more" if len(texts) > 6 else ""
        fault = f"these parameters cannot all be told apart (rank {len(base.chosen)} of {len(self.names)})"
        raise InputError(f"{fault}: {'; '.join(texts[:6])}{more}; leave some out, or give the motion more freedom")


def build_design(
    robot: Robot,
    shape: Shape | None = None,
    goal: Goal | NearGoal | None = None,
    *,
    bounds: JointBounds | None = None,
    loads: Loads | None = None,
    scene: Scene | None = None,
) -> DesignProblem:
    """Build the problem; ``solve_design`` solves it. What the robot's description lacks is assumed, with a warning.

    Args:
        shape: of the motion; 14 via points if None.
        goal: what is to be learnt; the information about all base parameters if None.
        bounds: limits of the joints; the description's if None.
        loads: parameters for the torque limits; the description's if None. Unused without torque limits.
        scene: obstacles, and the bodies that must keep clear of them and of each other.

    Raises:
        InputError: if something is missing or does not fit; if the parameters cannot be told apart.
    """
    if loads is None and (bounds is None or np.isfinite(bounds.torque).any()):
        robot = completed(robot)
    shape, goal, bounds = shape or ViaPointShape(), goal or Goal(), bounds or JointBounds.of(robot)
    family, loads = shape.family(robot, bounds), loads or Loads(robot.parameters)
    if isinstance(goal, NearGoal):
        goal = goal.with_friction(robot, shape, family)
    model, base = goal.model(robot), base_parameters(robot) if np.isfinite(bounds.torque).any() else None
    needed, around, payloads = {*goal.names(robot), *(base.columns if base is not None else ())}, scene, None
    if isinstance(loads.heaviest, PayloadSet):
        payloads = loads.heaviest
        needed.update(payload_columns(robot))
        if scene is not None:
            # The ball that holds the payloads: clear of all surfaces, and of bodies below the wrist; of the tubes
            # along the chain the base's alone, for others reach to the wrist, next to a short flange.
            x, y, z = payloads.centre.tolist()
            ball = Capsule(BALL, robot.n, payloads.radius, (x, y, z))
            drawn = {tube.name for tube in tubes(robot, 1.0) if tube.link}
            below = (body.name for body in scene.bodies if body.link <= robot.n - _WRIST)
            pairs = ((ball.name, name) for name in below if name not in drawn)
            around = structs.replace(scene, bodies=(*scene.bodies, ball), pairs=(*scene.pairs, *pairs))
    # Columns stand in the robot's order, so that different goals share compiled code.
    columns = tuple(name for name in standard_columns(model) if name in needed)
    spring = (SPRING,) if base is not None and robot.spring is not None else ()
    kernel = regressor_kernel(model, (*columns, *spring))
    limits: list[Limit] = [*state_limits(bounds, family.reach)]
    if base is not None:
        limits += torque_limits(robot, base, kernel, bounds.torque, loads)
    if isinstance(shape, ViaPointShape) and shape.longest is not None:
        low, high, middle, unit = np.array([[-np.inf], [1.0], [0.0], [shape.longest]])
        measure = partial(total_time, shape.longest)
        limits.append(Limit("duration", "duration", ("motion",), low, high, middle, unit, measure))
    if around is not None:
        limits.append(clearance(robot, around))
    problem = DesignProblem(model, bounds, family, goal, kernel, tuple(limits), payloads, around)
    start = None if isinstance(shape, NearShape) else shape.start
    for limit in problem.of_kind("clearance") if start is not None else ():
        if (nearest := check(limit, problem.at_rest(np.array([start])))).room < 0.0:
            raise InputError(f"choose another start pose: {nearest} m")
    problem.require_full_rank(family.random(np.random.default_rng(0)))
    return problem
