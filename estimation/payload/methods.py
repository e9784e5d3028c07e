"""The paper's four methods: section V, (22) to (30), each with its equation, its columns and what is known of them.

chi are the robot's base parameters, W their columns; chi_L the payload's ten, W_L theirs. A column is wanted, free
(estimated with them), fixed (known, with a covariance) or given a soft prior at zero or at what is known.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain

import numpy as np

from ...common import Array, Brief, InputError, decomposed, one_thread
from ...model import InertialParameters
from ...model.drives import parameter_kind
from ...model.friction import is_friction
from ...model.regressors import payload_columns
from ..equations.equations import PAYLOAD, Equations, check_blocks
from ..equations.observer import PATH
from ..fit.covariance import FEW, RobustCovariance, Rule, jackknife
from ..fit.estimate import Estimate, Gains, error_model, fit
from ..fit.linear_problem import LinearProblem, SoftPrior, left_out, weighted
from ..possible.constraints import Constraint
from ..possible.intervals import NO_INTERVALS, Intervals, profile_intervals
from ..possible.payload import CONFLICT, POSSIBLE, Active, Possible, solve_constrained, tested
from .long_motion import LongMotion, frame_change, in_payload_frame, known_path, prior_of
from .short_motion import ShortMotion, StaticMotion

PayloadProblem = LongMotion | ShortMotion


@dataclass(frozen=True, eq=False, repr=False)
class PayloadEstimate(Brief):
    """Payload estimated by one method: all ten parameters, or those that a short motion determines."""

    method: int  # 1 to 4
    estimate: Estimate  # of ``PAYLOAD``, about the origin of ``frame``
    frame: str
    without_robust: str = ""  # why there are no robust standard deviations although they were asked for
    from_scale: bool = False  # whether the mass is a scale's, not the torques'

    @cached_property
    def indices(self) -> tuple[int, ...]:
        """Indices of the determined parameters among the ten."""
        return tuple(PAYLOAD.index(name) for name in self.estimate.names)

    def unexplained(self, torque_rms: Array) -> Array:
        """Ratio of each joint's error to another torque (rms), shape (n,); nan without equations or torque."""
        fit = self.estimate.fit
        there = (np.array(fit.rows) > 0) & (torque_rms > 0.0)
        return np.asarray(fit.rms / np.where(there, torque_rms, np.nan))

    @property
    def ten(self) -> Array:
        """Ten parameters, nan where not determined, shape (10,)."""
        values = np.full(len(PAYLOAD), np.nan)
        values[list(self.indices)] = self.estimate.values
        return values

    @cached_property
    def body(self) -> InertialParameters:
        """Payload as a body; all ten must be determined."""
        return InertialParameters(self.estimate.values)

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        return self.body.mass


def moved(
    estimate: PayloadEstimate, change: Array | None = None, more: Array | None = None, factor: float | Array = 1.0
) -> PayloadEstimate:
    """Change the values, multiply sigmas by one ``factor`` or one each and add ``more`` covariance; of the ten."""
    indices, own = list(estimate.indices), estimate.estimate
    wider = 0.0 if more is None else more[np.ix_(indices, indices)]
    factors = np.outer(factor, factor)
    robust = own.robust and replace(own.robust, covariance=factors * own.robust.covariance + wider)
    values = own.values if change is None else own.values + change[indices]
    covariance = factors * own.covariance + wider
    return replace(estimate, estimate=replace(own, values=values, covariance=covariance, robust=robust))


@dataclass(frozen=True, eq=False, repr=False)
class ConstrainedPayload(Brief):
    """Payload nearest to one method's estimate, by ``error_model``, among those that keep the constraints."""

    free: PayloadEstimate  # the method's own estimate
    result: Possible
    intervals: Intervals  # 95 %; nan where a constraint contradicts the data
    gains: Gains | None  # errors that are part of the covariance; None where gains are taken as exact
    tested: tuple[Active, ...]  # active constraints with the probability of what each costs

    @property
    def method(self) -> int:
        """Number of the method, 1 to 4."""
        return self.free.method

    @property
    def body(self) -> InertialParameters:
        """Payload as a body that can exist."""
        return self.result.body

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        return self.body.mass

    @cached_property
    def principal_moments(self) -> Array:
        """Principal moments of inertia at the centre of mass, rising [kg m^2], shape (3,)."""
        return np.asarray(np.linalg.eigvalsh(self.body.inertia_com))

    @property
    def conflict(self) -> bool:
        """True if a constraint or a weighed mass, or all of them together, contradict the data."""
        alone = [*(active.conflict for active in self.tested), *(one.conflict for one in self.result.weighings)]
        return any(alone) or self.result.p_value < CONFLICT


def constrain_payload(
    free: PayloadEstimate, constraints: Sequence[Constraint] = POSSIBLE, gains: Gains | None = None
) -> ConstrainedPayload:
    """Find the nearest payload that can exist and keeps constraints, with intervals; ``gains``: exact by default.

    Raises:
        InputError: if not all ten are determined, or what they owe to the drive gains is not known.
        SolverError: for anything but a clean solve, as when no body holds all constraints.
    """
    result = solve_constrained(error_model(free.estimate, gains), constraints)
    tests = tested(result)
    contradicted = result.p_value < CONFLICT or any(test.conflict for test in tests)
    intervals = NO_INTERVALS if contradicted else profile_intervals(result)
    return ConstrainedPayload(free, result, intervals, gains, tests)


def from_robot(motion: LongMotion) -> LinearProblem:
    """Method 1, (22): Y_T = W chi + W_L chi_L, and (23): Y_T - W chi = W_L chi_L.

    Wanted: chi_L. Fixed: chi, by the recordings without payload or an earlier identification; its covariance
    counts, C_L = s^2 (W_L' W_L)^-1 + P C P' with P = W_L^+ W.

    Beyond the paper: of a robot that was identified on another day chi is a soft prior, and each friction may
    differ from it within limits; where asked for, friction is free, for it may depend on load.
    """
    free_friction = motion.settings.free_friction
    if motion.corrected and not free_friction:
        loaded, changes = under_load(motion, motion.friction)
        prior = prior_of(motion.known, motion.inflation, motion.loaded)
        return LinearProblem(loaded, PAYLOAD, soft=changes, prior=prior)
    loaded, scale = under_load(motion, {})
    robot = motion.robot_known
    if free_friction:
        robot = robot.part([name for name in robot.names if not is_friction(name)])
    return LinearProblem(loaded, PAYLOAD, (robot,), scale)


class ChangeOfParameters:
    """Method 2, (24): Y_a = W_a chi and Y_T = W_T chi_T, two identifications; (25)-(28): chi_T - chi = G_L chi_L.

    Wanted: chi_L. G_L (N_b x 10) holds the last link's columns of the grouping matrix; on the RX90 its rows are
    (25)-(28). Solved by least squares weighted by the covariance of chi_T - chi. Drive parameters take no part:
    friction may change under load.
    """

    def __init__(self, motion: LongMotion) -> None:
        """Take recordings with payload and without; refuse a motion that lacks these."""
        if motion.bare is None or motion.unloaded is None:
            raise InputError("method 2 needs a recording without payload")
        robot, columns = motion.robot, motion.base.columns
        self.before, self.unloaded = motion.bare, motion.unloaded  # chi and its equations
        self.loaded = motion.loaded.select(columns)  # in chi_T
        self.both = in_payload_frame(robot, motion.loaded)  # the same in chi and chi_L
        # Indices of the inertial parameters among chi, and their rows of G_L, the payload in its frame.
        self.indices = [k for k, own in enumerate(columns) if not is_friction(own) and parameter_kind(own) != "IA"]
        self.G = motion.base.effect_of(payload_columns(robot))[self.indices] @ frame_change(robot.flange)

    def solved(self, weights: Array | None = None) -> Estimate:
        """Estimate the payload's ten parameters."""
        after, k = weighted(self.loaded, weights), self.indices
        C = (self.before.covariance + after.covariance)[np.ix_(k, k)]
        change = (after.values - self.before.values)[k]
        x, covariance, inverse = _generalised(self.G, change, C)
        # By the gains' relative errors, the change of the weights by them included: of x = (G'C^-1G)^-1 G'C^-1 d is
        # dx = inverse (dd - dC C^-1 (d - G x)), C the variances of both.
        weighted_rest, by_gains = np.linalg.solve(C, change - self.G @ x), np.zeros((len(k), len(after.weights)))
        for equations, estimate, sign in ((self.unloaded, self.before, -1.0), (self.loaded, after, 1.0)):
            assert estimate.gain_sensitivity is not None
            by_gains += sign * estimate.gain_sensitivity[k]
            # The residual's variance grows as its errors do with each motor's torque.
            chi = np.append(-estimate.values, 1.0)
            errors = [w * factor @ chi for w, factor in zip(estimate.weights, equations.factors, strict=True)]
            size = max(sum(float(error @ error) for error in errors), np.finfo(float).tiny)
            every = zip(errors, estimate.weights, equations.by_motor(), strict=True)
            grown = 2.0 * sum(error @ (w * torques) for error, w, torques in every) / size
            by_gains -= np.outer(estimate.covariance[np.ix_(k, k)] @ weighted_rest, grown)
        dof = min(self.before.degrees_of_freedom, after.degrees_of_freedom)
        shown = fit(self.both, np.concatenate([self.before.values, x]))
        return Estimate(PAYLOAD, x, covariance, dof, shown, after.weights, gain_sensitivity=inverse @ by_gains)

    def without_blocks(self, weights: Array, pairs: Sequence[tuple[int, int]]) -> Array:
        """Estimate the ten without a block of the loaded and one of the unloaded recordings, -1 for none."""
        k, names = self.indices, self.before.names
        before, after = left_out(self.unloaded, names, self.before.weights), left_out(self.loaded, names, weights)

        estimates = list[Array]()
        for b, a in pairs:
            (x, X), (y, Y) = before[a], after[b]
            estimates.append(_generalised(self.G, (y - x)[k, 0], X[k] @ X[k].T + Y[k] @ Y[k].T)[0])
        return np.array(estimates)


def _generalised(G: Array, change: Array, C: Array) -> tuple[Array, Array, Array]:
    """Solve G x = change with covariance C by generalised least squares: x, its covariance, x by the change."""
    scale = np.sqrt(np.diag(C))
    L = np.linalg.cholesky(C / np.outer(scale, scale))
    parts = decomposed(np.asarray(np.linalg.solve(L, G / scale[:, None])))
    if parts.null.size:
        raise InputError("the base parameters of this robot do not show all ten parameters of a payload")
    inverse = np.linalg.solve(L.T, parts.inverse.T).T / scale
    return parts.solution(np.asarray(np.linalg.solve(L, change / scale))), parts.root @ parts.root.T, inverse


def from_difference(motion: LongMotion) -> LinearProblem:
    """Method 3, (29): Y_T - Y_wL = W_L chi_L, torques with and without payload on one trajectory.

    Wanted: chi_L. Beyond the paper: the change of the robot's own torque due to the difference of the two paths is
    subtracted, a quarter of it (1 sigma) counting as uncertain; changes of friction under load have soft priors
    about zero. Y_wL is the paper's name for Y_a of one trajectory.
    """
    if motion.difference is None:
        raise InputError(f"method 3 cannot be used: {motion.why_no_pair}")
    there = [name for name in motion.difference.columns if name in (*PAYLOAD, PATH, *motion.friction)]
    difference = in_payload_frame(motion.robot, motion.difference.select(there))
    path = (known_path(motion.robot.n),) if PATH in there else ()
    return LinearProblem(difference, PAYLOAD, path, soft=motion.friction)


def global_fit(motion: LongMotion) -> LinearProblem:
    """Method 4, (30): [Y_a; Y_T] = [W_a 0; W_T W_L] [chi; chi_L], all recordings at once.

    Wanted: chi_L. Free: chi, common to both. Beyond the paper: changes of friction under load, and of the torques'
    scale where it is free, have soft priors about zero; ``weighted(motion.both)`` is (30) to the letter.
    """
    loaded, changes = under_load(motion, motion.friction)
    return LinearProblem(motion.with_unloaded(loaded), PAYLOAD, soft=changes, shown=loaded)


def under_load(motion: LongMotion, friction: Mapping[str, SoftPrior]) -> tuple[Equations, dict[str, SoftPrior]]:
    """[W W_L], the payload in its frame, and columns near zero for all that may be another one under load.

    Frictions may, and the scale of the torques, where it is free: 1 % of it (drives warm up, sensors drift) moves
    the mass by several percent, for the arm weighs more than its payload.
    """
    loaded, near = motion.loaded, dict[str, SoftPrior]()
    if motion.settings.scale_sigma > 0.0:
        robot, columns = motion.robot_known, (*loaded.columns, _SCALE)
        near[_SCALE] = SoftPrior(motion.settings.scale_sigma, max(motion.inflation, default=1.0))
        # It scales the torque of both, without friction; the payload's own is therefore found first.
        every = zip(robot.names, robot.values.tolist(), strict=True)
        scaled = {name: value for name, value in every if not is_friction(name)}

        def with_scale() -> Equations:
            column = [scaled.get(name, 0.0) for name in columns[:-1]]
            return motion.loaded.transformed(np.column_stack([np.eye(len(column)), column]), columns)

        values = LinearProblem(with_scale(), (*PAYLOAD, _SCALE), (robot,), near).solved().values
        scaled |= zip(PAYLOAD, (values[:-1] / (1.0 + values[-1])).tolist(), strict=True)
        loaded = with_scale()
    loaded = in_payload_frame(motion.robot, loaded)
    M = np.eye(len(loaded.columns))[:, [*range(len(loaded.columns)), *map(loaded.columns.index, friction)]]
    changes = {f"{name} under load": role for name, role in friction.items()}
    return loaded.transformed(M, (*loaded.columns, *changes)), near | changes


_SCALE = "scale under load"
_FORMULA_ONLY = (
    "the stored robot parameters have the formula's standard deviations only: identify the robot again, by a "
    "longer recording"
)
Posed = LinearProblem | ChangeOfParameters
"""A problem of the payload that is solved for given weights of the joints, with and without blocks of time."""
PREFERRED = (3, 4, 1, 2)
"""Methods in the order of their expected errors, where each can be used and a pair ran one path."""
ONE_PATH = 2e-3  # distance of positions [rad or m], rms of the worst joint, above which a pair is not of one path
METHODS: dict[int, Callable[[LongMotion], Posed]]
METHODS = {1: from_robot, 2: ChangeOfParameters, 3: from_difference, 4: global_fit}
"""Methods of the paper by number."""


def usable_methods(problem: PayloadProblem) -> tuple[int, ...]:
    """Numbers of the methods for which the problem holds what they need."""
    if isinstance(problem, ShortMotion):
        return (problem.method,)
    unloaded, difference = problem.unloaded is not None, problem.difference is not None
    one_scale = not problem.settings.scale_sigma > 0.0  # changes and differences know of no other
    usable = unloaded or problem.known is not None, unloaded and one_scale, difference and one_scale, unloaded
    return tuple(method for method, there in enumerate(usable, 1) if there)


@one_thread()
def payload_estimate(problem: PayloadProblem, method: int, covariance: Rule | None = None) -> PayloadEstimate:
    """Estimate the payload by one method, robustly where there are blocks; of a short motion what it determines.

    Args:
        method: 1 robot known (22)-(23), 2 change of the base parameters (24)-(28), 3 torque difference (29),
            4 robot and payload together (30).
        covariance: rule for it; by default the jackknife, with few blocks the sandwich.

    Raises:
        InputError: if the problem lacks what the method needs; "mass not visible" if nothing shows it.
        KeyError: for another method.
    """
    frame = problem.robot.payload_frame
    if isinstance(problem, LongMotion):
        estimate, reason = with_robust(problem, METHODS[method](problem), rule=covariance)
        return PayloadEstimate(method, estimate, frame, reason)
    if method != problem.method:
        raise InputError(f"method {method} cannot be used: this short motion is one for method {problem.method}")
    by_scale = problem.needed_scale is not None
    estimate, reason = with_robust(problem, problem.posed(), rule=covariance)
    return PayloadEstimate(method, problem.resolved(estimate), frame, reason, by_scale)


def recommended_method(problem: PayloadProblem, methods: Iterable[int]) -> tuple[int, str]:
    """Choose the method with the least expected error of those that gave a payload, and say why of several.

    On one path method 3 cancels what the robot's model lacks, which methods 1, 2 and 4 carry; where the paths
    differ, it must subtract the robot's own torque difference. To choose by the shortest interval would be biased.
    """
    there, compared = sorted(methods, key=PREFERRED.index), problem.source.compared
    apart = max((pair.rms_mismatch for pair in compared), default=float("inf"))
    if there[:2] == [3, 4] and apart > ONE_PATH:
        there.remove(3)
    best, reason = there[0], ""
    if len(there) > 1 and best == 3 and apart <= ONE_PATH:
        unit = "mrad" if all(joint.revolute for joint in problem.robot.joints) else "mrad or mm"
        reason = f"both follow one path (within {max(1e3 * apart, 0.01):.2g} {unit}), so errors of the model cancel"
    elif len(there) > 1 and best == 4 and apart > ONE_PATH:
        reason = f"{'not every' if len(compared) > 1 else 'no'} pair follows one path, which method 3 needs"
    return best, reason


def selected(motion: LongMotion, names: Sequence[str]) -> LinearProblem:
    """Estimate some parameters of robot and payload by method 4, the others zero."""
    return LinearProblem(motion.both.select(names), tuple(names))


def with_robust(
    problem: PayloadProblem, posed: Posed, estimate: Estimate | None = None, rule: Rule | None = None
) -> tuple[Estimate, str]:
    """Add the robust covariance to the estimate of a posed problem; give the reason where there is none.

    Args:
        estimate: its result, where it is there already; its weights are kept.
        rule: for the covariance; by default the jackknife where there are blocks enough, else the sandwich.
    """
    estimate = posed.solved() if estimate is None else estimate
    long, known, loaded = isinstance(problem, LongMotion), problem.known, problem.loaded
    weights, length, blocks, own = estimate.weights, loaded.block_length, 0, known and known.robust
    robust: RobustCovariance | None = None
    if rule == "formula":
        return estimate, ""
    if long and not loaded.blocks:  # nothing was cut into blocks of what is compared with a robot known by formula
        return estimate, _FORMULA_ONLY if problem.settings.robust and known is not None and own is None else ""
    try:
        try:
            robust = None if rule == "sandwich" else jackknifed(posed, estimate, problem.left_out, length)
        except InputError:
            if rule == "jackknife" or not (long and problem.inflation):
                raise
        if robust is not None:
            blocks, few = robust.blocks, problem.corrected and robust.degrees_of_freedom + 1 < FEW
            # What no block shows; none where nothing known is made use of, as by method 2.
            lasting = posed.lasting(weights) if isinstance(posed, LinearProblem) else 0.0 * estimate.covariance
            if lasting.any():
                # A robot that was identified earlier adds its own robust covariance, propagated.
                if long and known is not None and own is None:
                    raise InputError(_FORMULA_ONLY)
                robust = RobustCovariance(
                    robust.covariance + lasting,
                    blocks + (own.blocks if own else 0),
                    min(robust.degrees_of_freedom, own.degrees_of_freedom) if own else robust.degrees_of_freedom,
                    max(length, own.block_length) if own else length,
                )
            if isinstance(problem, StaticMotion):  # of few poses the jackknife may be too small by chance
                wider = np.maximum(np.sqrt(np.diag(estimate.covariance + lasting)) / robust.sigma, 1.0)
                robust = replace(robust, covariance=robust.covariance * np.outer(wider, wider))
            if rule == "jackknife" or not (few or (isinstance(problem, LongMotion) and problem.few)):
                return replace(estimate, robust=robust), ""
        # By how much each joint's errors remember; the jackknife's sigmas count where they are larger.
        if not problem.inflation:
            raise InputError("a sandwich needs recordings in blocks of time: how long errors remember is not known")
        covariance = float(np.median(problem.inflation)) * estimate.covariance
        if isinstance(posed, LinearProblem):
            covariance = posed.sandwich(weights, problem.inflation)
        # A stored robot that a short loaded recording corrects has too few blocks for a jackknife: it is left out.
        if robust is not None and not problem.corrected:
            wider = np.maximum(robust.sigma / np.sqrt(np.diag(covariance)), 1.0)
            covariance = covariance * np.outer(wider, wider)
        degrees = max(int(estimate.degrees_of_freedom), 1)
        robust = RobustCovariance(covariance, blocks, degrees, length, by_memory=True)
        return replace(estimate, robust=robust), ""
    except InputError as error:
        return estimate, str(error)


def jackknifed(
    posed: Posed, estimate: Estimate, groups: Sequence[Sequence[tuple[int, int]]], length: float
) -> RobustCovariance:
    """Solve without each block of time, group by group, weights fixed; ``length``: the shortest of a block [s]."""
    check_blocks(*map(len, groups))
    try:
        values = posed.without_blocks(estimate.weights, list(chain.from_iterable(groups)))
    except InputError as error:
        raise InputError(f"no robust standard deviations: without one block of {length:.2g} s, {error}") from None
    return jackknife(np.split(values, np.cumsum([*map(len, groups)])[:-1]), estimate.values, length)
