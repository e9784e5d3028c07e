"""Goal of a motion: which parameters it is to teach, by which criterion, and what is known already.

A motion near a pose is to tell of a payload, together with constant torques and friction that change by the day.

The observation matrix W on a motion's samples has the Gram matrix G = W' diag(w) W, c x c. Each criterion is a
number to be made small, with the symmetric M = dC/dG. The condition number is not smooth where eigenvalues meet,

    log cond(W) <= (log tr G^p + log tr G^-p) / (2 p),

its surrogate of order p, is, and tends to it as p grows (a Schatten norm). With M, dC/dW = 2 w W M. Torques are
linear in W as well, so that slopes of torque limits join the same seed; reverse mode of the regressor then gives
the slopes in q, qd and qdd at about the cost of a few evaluations.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, product
from typing import NamedTuple

import casadi as ca
import numpy as np

from ...common import Array, ArrayLike, Brief, InputError, decomposed, without
from ...common.errors import listed
from ...model import InertialParameters, Robot, base_parameters, standard_columns
from ...model.base import check_mass_visible, friction_columns, leftmost_independent, visibility_of
from ...model.drives import SPRING, parameter_kind, smooth_sign
from ...model.inertia import PayloadSpread, payload_spread
from ...model.kernel.kernel import Kernel
from ...model.regressors import own_regressor, payload_columns
from ..motions.family import JointBounds, Plan, Samples
from ..motions.fourier import FourierShape, FreeSeries, NearShape
from ..motions.via_points import FreeRests, FreeViaPoints, StaticShape, ViaPoints, ViaPointShape

Shape = ViaPointShape | FourierShape | NearShape | StaticShape
"""Kinds of motion among which a design chooses: each is a small value that stands for a family."""
Family = FreeViaPoints | FreeSeries | FreeRests
"""Families of motions that depend smoothly on a vector x of a ``size``, its entries of the order of 1 within
``low`` and ``high``: ``random`` draws an x to start from, through clear poses if it can, ``sample`` evaluates
states on the grid of the optimisation, or on a finer one, ``pullback`` gives the gradient in x of a number by that
in the samples, ``plan`` makes the motion, ``eased`` one that is slower, where the duration is free, and smaller.
``reach``: lowest and highest positions, (n,), or (k, n) for k equal parts of the samples."""

RESIDUAL, MEMORY, INDEPENDENT = 0.004, 1.8, 10.0
"""Torque errors assumed of a recording: standard deviation over the torque limits, times what memory adds to it;
and samples a second that are then independent [Hz].

Real residuals at 10 to 50 Hz over the limits: of a UR10e .26 to .38 %, of a TX40 .24 to .31 % (arm) and 1.1 to
2.4 % (wrist); jackknife over formula 1.9 and 1.7, geometric mean over the parameters.
"""
ASSUMED_RATIO = RESIDUAL * MEMORY
ASSUMED_NOISE = f"assumed to be {100 * ASSUMED_RATIO:.2g} % of the torque limits, as on real arms"
ASSUMED_STICTION = 0.05 * 0.1, "assumed, 5 % of a Coulomb friction of 10 % of the torque limits"
"""Scatter of the torque at rest from one approach to the next over the torque limits, and its source."""
_CHANGE, _WRIST = 0.033 / 0.05, 3
"""Change of a joint's constant torque between two recordings over that scatter, 3.3 % of Coulomb friction over 5 %;
of so many last joints it is free: as a weighing takes it."""
_PAIR = 2.0  # times the variance: payloads show in the difference of two recordings
_ALIKE = {"M": 0.01, "MX": 1e-3, "MY": 1e-3, "MZ": 1e-3}
"""Standard deviations that count alike: of the mass 10 g times the shape's ``mass_alike``, of the first moments 1
mm times the mass expected; of inertias ``_INERTIA``."""
_INERTIA = 0.02  # kg m^2
_SLOW = 0.03  # rad/s or m/s: rows of a slower joint are not used; the sign of its friction is not sure
_APART = 0.5 * np.pi  # rad: between two wrist poses
_GLANCES, _LOOKS = 2, 6  # random motions by which second poses are compared: all of them, and then the best few
_FEW = 5
_LOOKED = 200.0  # samples of each of them
_HELPS = 0.75  # of the uncertainty with one pose: above it a second pose is not worth leaving the range
Kind = str  # name of a criterion: a key of ``CRITERIA``
_SINGULAR = 1e-15  # of the largest eigenvalue: smaller ones are rounding
ValueSlope = tuple[float, Array]  # value of a criterion, and M = dC/dG, c x c


class Criterion(NamedTuple):
    """Criterion that is to be made small, and rules by which it is searched for."""

    kind: Kind
    # value and slope by the criterion, G and the order p
    measure: Callable[[Criterion, Array, float], ValueSlope]
    weighted: bool  # whether the joints' torque noise weights the rows of W
    orders: tuple[float, ...]  # p of the surrogate, one after the other; 1 where there is none
    usual_starts: int  # random starts of a search, which ends at one of many local optima
    reference: Array | None = None  # values that standard deviations are relative to, shape (c,); for "a"
    # indices of the parameters that count for "d" and "a", the others being estimated besides them; None for all
    interest: Sequence[int] | None = None

    def __call__(self, G: Array, order: float = 1.0) -> ValueSlope:
        """Evaluate value and slope; ``order`` p of the surrogate. Value inf if G is not positive definite."""
        try:
            return self.measure(self, G, order)
        except np.linalg.LinAlgError:
            return np.inf, np.zeros_like(G)


def determinant(criterion: Criterion, G: Array, _: float) -> ValueSlope:
    """-log det of the information on parameters of interest, per one: twice the log of sigma's geometric mean."""
    inverse, log_det = _inverted(G)
    if criterion.interest is None:
        return -log_det / len(G), inverse / -len(G)
    # The others estimated as well, the covariance is its block of the inverse; d(G^-1) = -G^-1 dG G^-1 its slope.
    own = list(criterion.interest)
    part = inverse[np.ix_(own, own)]
    scale = np.sqrt(np.diag(part))
    value = np.linalg.slogdet(part / np.outer(scale, scale))[1] + 2.0 * np.log(scale).sum()
    M = -inverse[:, own] @ np.linalg.solve(part, inverse[own]) / len(own)
    return float(value) / len(own), 0.5 * (M + M.T)


def relative_sigma(criterion: Criterion, G: Array, _: float) -> ValueSlope:
    """Log of the root mean square of sigma_k / reference_k."""
    inverse, _ = _inverted(G)
    own = list(range(len(G)) if criterion.interest is None else criterion.interest)
    reference = np.ones(len(G)) if criterion.reference is None else criterion.reference
    weight = np.zeros(len(G))
    weight[own] = 1.0 / (len(own) * reference[own] ** 2)
    total = float(weight @ np.diag(inverse))
    return 0.5 * float(np.log(total)), -(inverse * weight) @ inverse / (2.0 * total)


def _inverted(G: Array) -> tuple[Array, float]:
    scale = _sizes(G)
    factor = np.linalg.cholesky(G / np.outer(scale, scale))
    half = np.linalg.inv(factor) / scale
    return half.T @ half, 2.0 * float(np.log(np.diag(factor) * scale).sum())


def _sizes(G: Array) -> Array:
    scale = np.sqrt(np.diag(G))
    if not ((scale > 0.0) & (scale < np.inf)).all():
        raise np.linalg.LinAlgError("not positive definite")
    return scale


def condition(criterion: Criterion, G: Array, order: float) -> ValueSlope:
    """Surrogate of log cond(W) of order p, by "cond-scaled" with W's columns scaled to norm 1; slope in G = W'W."""
    scaled = criterion.kind == "cond-scaled"
    scale = _sizes(G) if scaled else np.ones(len(G))
    D = np.outer(scale, scale)
    value, V = np.linalg.eigh(G / D)
    log = np.log(np.maximum(value, _SINGULAR * value[-1]))
    up, down = np.exp(order * (log - log[-1])), np.exp(order * (log[0] - log))
    level = (np.log(up.sum()) + np.log(down.sum())) / (2.0 * order) + 0.5 * (log[-1] - log[0])
    M = (V * (0.5 * (up / up.sum() - down / down.sum()) * np.exp(-log))) @ V.T
    slope = M / D
    if scaled:  # the chain rule through D, whose entries are those of G's diagonal
        slope[np.diag_indices_from(slope)] -= np.einsum("ij,ij->i", M, G / D) / np.diag(G)
    return float(level), slope


_SURROGATE = (1.0, 8.0, 24.0)  # orders p, one after the other: the last is near the condition number itself
CRITERIA = {
    "d": Criterion("d", determinant, weighted=True, orders=(1.0,), usual_starts=6),
    "a": Criterion("a", relative_sigma, weighted=True, orders=(1.0,), usual_starts=6),
    "cond": Criterion("cond", condition, weighted=False, orders=_SURROGATE, usual_starts=3),
    "cond-scaled": Criterion("cond-scaled", condition, weighted=False, orders=_SURROGATE, usual_starts=3),
}
"""Criteria by name: d: log det; a: relative standard deviations; cond: condition number of W in SI
units; cond-scaled: of W with its columns scaled to norm 1. To add one, add a row."""


class RegressorKernel:
    """Evaluates the regressor's non-zero entries, joint by joint, and their adjoint; ``SPRING`` may be a column."""

    def __init__(self, robot: Robot, columns: Sequence[str]) -> None:
        self._robot, self.columns = robot, tuple(columns)
        own = [name for name in columns if name != SPRING]
        width, spring = ca.SX.sym("width"), ca.SX(robot.n, 1)
        (q, qd, qdd, _), exact = own_regressor(robot, own)
        _, smooth = own_regressor(robot, own, smooth_sign(width))
        if robot.spring is not None:
            spring[robot.spring.joint - 1] = robot.spring.law(q[robot.spring.joint - 1])
        order = [[*own, SPRING].index(name) for name in columns]
        smooth, exact = (ca.horzcat(phi, spring)[:, order].T for phi in (smooth, exact))
        seed, state = ca.SX.sym("seed", smooth.nnz()), ca.vertcat(q, qd, qdd)
        slope = ca.cse(ca.densify(ca.jtimes(smooth.nz[:], state, seed, True)))
        self._smooth = Kernel(ca.Function("smooth_entries", [q, qd, qdd, width], [ca.cse(smooth)]))
        self._exact = Kernel(ca.Function("exact_entries", [q, qd, qdd], [ca.cse(exact)]))
        self._adjoint = Kernel(ca.Function("adjoint", [q, qd, qdd, width, seed], [slope]))
        # The matrix is transposed: column-major order then holds joint after joint, its entries and their columns.
        ends = np.searchsorted(self._smooth.columns, np.arange(robot.n + 1))
        self.parts = tuple((slice(int(a), int(b)), self._smooth.rows[a:b]) for a, b in pairwise(ends))
        self._blocks = tuple(np.ix_(own, own) for _, own in self.parts)

    def __reduce__(self) -> tuple[Callable[..., RegressorKernel], tuple[Robot, tuple[str, ...]]]:
        """Pickle and copy by what it is made from: code is compiled, or kept already, where it is used."""
        return regressor_kernel, (self._robot, self.columns)

    def state(self, samples: Samples, width: float = 0.0) -> Samples:
        """Evaluate the non-zero entries on samples, their sign smoothed over ``width``, 0 for the exact one."""
        states = (*samples[1:4], np.array([width]))
        entries = self._smooth(*states) if width > 0.0 else self._exact(*states[:3])
        return samples._replace(entries=entries, width=states[3])

    def gram(self, entries: Array, weights: Array) -> Array:
        """Gram matrix W' diag(w) W, c x c, with ``weights`` (n, N)."""
        G = np.zeros((len(self.columns), len(self.columns)))
        for (part, _), block, w in zip(self.parts, self._blocks, weights, strict=True):
            W = entries[part]
            G[block] += (W * w) @ W.T
        return G

    def gram_slope(self, entries: Array, weights: Array, M: Array, seed: Array) -> Array:
        """Slopes of tr(M G), M symmetric and fixed, in the weights (n, N); those in the entries into ``seed``."""
        by_weight = np.empty_like(weights)
        for j, ((part, _), block) in enumerate(zip(self.parts, self._blocks, strict=True)):
            MW = M[block] @ entries[part]
            by_weight[j] = np.einsum("kn,kn->n", MW, entries[part])
            MW *= 2.0 * weights[j]
            seed[part] += MW
        return by_weight

    def torque(self, entries: Array, chi: Array) -> Array:
        """Torques W chi, shape (N, n)."""
        return np.stack([chi[own] @ entries[part] for part, own in self.parts], axis=1)

    def torque_slope(self, slope: Array, chi: Array, seed: Array) -> None:
        """Add to ``seed`` what a slope in the torques (N, n) means for the entries, of chi (c,), or (c, n, N)."""
        for j, (part, own) in enumerate(self.parts):
            seed[part] += (chi[own][:, None] if chi.ndim == 1 else chi[own, j]) * slope[:, j]

    def state_slope(self, state: Samples, seed: Array) -> list[Array]:
        """Slopes in q, qd, qdd, each (N, n), from slopes in the entries."""
        return np.split(self._adjoint(*state[1:4], state.width, seed.T).T, 3, axis=1)

    def matrix(self, state: Samples) -> Array:
        """Matrix W with its zeros, n x N x c, of samples whose entries are known."""
        W = np.zeros((len(self.parts), len(state.q), len(self.columns)))
        for rows, (part, columns) in zip(W, self.parts, strict=True):
            rows[:, columns] = state.entries[part].T
        return W


@functools.lru_cache(maxsize=16)
def regressor_kernel(robot: Robot, columns: tuple[str, ...]) -> RegressorKernel:
    """Make the kernel of a robot and its columns, once."""
    return RegressorKernel(robot, columns)


@dataclass(frozen=True, eq=False, repr=False)
class Earlier(Brief):
    """Information of earlier recordings: R of a QR decomposition of their observation matrix.

    For "d" and "a" the rows of W are divided by the joints' torque noise, for condition numbers they are not.

    Attributes:
        columns: names of the columns, c.
        factor: k x c.
    """

    columns: tuple[str, ...]
    factor: Array


@dataclass(frozen=True, eq=False, repr=False)
class Goal(Brief):
    """Parameters to be learnt, and how their uncertainty is measured.

    Attributes:
        criterion: "d", "a", "cond" or "cond-scaled", as in ``CRITERIA``.
        columns: names of the parameters that will be estimated; None for all base parameters.
        payload_only: the last link's ten inertial parameters instead, the robot being known.
        interest: the parameters that count ("d" and "a"), the others being estimated besides; None for all.
        reference: values that standard deviations are relative to, by name; "a" needs them.
        noise: standard deviation of the torque noise of a recording per joint [N·m or N], shape (n,); None for
            ``assumed_noise``, inf for a joint whose torque is not used.
        rate: independent samples per second that will be recorded [Hz].
        noise_from: source of the noise, in words; that of assumed noise is ``noise_source``.
        data_length: how long will be recorded, the motion being repeated [s]; None for one motion as it is.
        offsets: whether ``columns`` may name constant torques of the joints, though the robot has none of its own.
        paired: whether torques are differences of two recordings, as those of a payload alone always are.
    """

    criterion: Kind = "d"
    columns: tuple[str, ...] | None = None
    payload_only: bool = False
    interest: tuple[str, ...] | None = None
    reference: Mapping[str, float] | None = None
    noise: ArrayLike | None = None
    rate: float = INDEPENDENT
    noise_from: str = "as given"
    data_length: float | None = None
    earlier: Earlier | None = None
    offsets: bool = False
    paired: bool = False

    def __post_init__(self) -> None:
        if self.criterion not in CRITERIA:
            raise InputError(f"criterion {self.criterion!r} is not one of {', '.join(CRITERIA)}")
        if self.payload_only and self.columns is not None:
            raise InputError("payload_only names the parameters itself: leave columns out")
        if self.interest is not None and self.criterion not in ("d", "a"):
            raise InputError("interest counts for d and a only: name the columns of a condition number instead")
        if self.criterion == "a" and not self.reference:
            raise InputError("criterion a needs reference values that standard deviations are relative to")
        if self.earlier is not None and self.data_length is None:
            raise InputError("with earlier recordings the data length to come must be given")

    @property
    def noise_source(self) -> str:
        """Source of the torque noise, in words."""
        return ASSUMED_NOISE if self.noise is None else self.noise_from

    def sigma(self, robot: Robot) -> Array:
        """Standard deviation of the torques per joint [N·m or N], shape (n,); 1 where no limit tells it."""
        assumed = assumed_noise(robot)
        usual = np.where(np.isfinite(assumed), assumed, 1.0)
        noise = usual if self.noise is None else np.asarray(self.noise, dtype=float)
        if noise.shape != (robot.n,) or not (noise > 0.0).all() or not np.isfinite(noise).any():
            raise InputError(f"torque noise: robot {robot.name!r} needs {robot.n} positive numbers")
        return noise

    def model(self, robot: Robot) -> Robot:
        """Robot with all columns that the goal may name."""
        return robot.with_offsets(True) if self.offsets else robot

    @property
    def single_rate(self) -> float:
        """Rate of independent samples that say as much without a second recording [Hz]."""
        return self.rate / _PAIR if self.paired or self.payload_only else self.rate

    def names(self, robot: Robot) -> tuple[str, ...]:
        """Names of the parameters.

        Raises:
            InputError: for a name that the robot does not have.
        """
        names = payload_columns(robot) if self.payload_only else self.columns or base_parameters(robot).columns
        known, interest = standard_columns(self.model(robot)), self.interest or ()
        wrong = [name for name in names if name not in known] + [name for name in interest if name not in names]
        if wrong or not names or len(set(names)) != len(names):
            fault = listed(wrong or ["none or the same twice"])
            raise InputError(f"cannot design for these parameters of robot {robot.name!r}: {fault}")
        return names


@dataclass(frozen=True, eq=False, repr=False)
class NearGoal(Brief):
    """Goal of a motion near a pose: a payload seen in noisy torques of the joints that the motion moves.

    They move all the time as a ``NearShape`` says, or stand still in a ``StaticShape``, each approach one sample.

    Attributes:
        noise: standard deviation of a torque sample of a recording per joint [N·m or N], shape (n,).
        rate: independent torque samples per second [Hz]; of a ``StaticShape`` one in the time that a pose is held.
        expected: about what the payload is; what is predicted depends on it.
        mass_sigma: of the scale on which the payload was weighed [kg]; None where it was not.
        noise_from: source of the noise, in words.
    """

    noise: Array
    rate: float
    expected: InertialParameters
    mass_sigma: float | None = None
    noise_from: str = "as given"

    def with_friction(self, robot: Robot, shape: Shape, family: Family) -> Goal:
        """Extend the goal to all that such motions tell apart: of the payload, and of friction.

        Raises:
            InputError: "mass not visible" where the mass is neither visible nor known.
        """
        if not isinstance(shape, NearShape | StaticShape):
            raise InputError("this goal is for motions near a pose: give a NearShape or a StaticShape")
        visibility = shape.visibility(robot)
        check_mass_visible(visibility, self.mass_sigma is not None, "near this pose")
        payload, moving = payload_columns(robot), [joint - 1 for joint in shape.joints]
        kernel, samples = _payload_kernel(robot), family.sample(family.random(np.random.default_rng(0)))
        W = kernel.matrix(kernel.state(samples))[moving].reshape(-1, len(kernel.columns))
        indices = [*visibility.base.chosen, *range(len(payload), len(kernel.columns))]
        names = tuple(kernel.columns[indices[k]] for k in leftmost_independent(W[:, indices]))
        interest = tuple(name for name in names if name in payload)
        mass = self.expected.mass
        scales = {name: _ALIKE.get(parameter_kind(name), _INERTIA / mass) for name in interest}
        alike = {name: scale * (shape.mass_alike if name == payload[9] else mass) for name, scale in scales.items()}
        noise = np.where(np.isin(np.arange(robot.n), moving), self.noise, np.inf)
        known = {} if self.mass_sigma is None else {payload[9]: self.mass_sigma}
        if isinstance(shape, StaticShape):
            known |= {f"OFF{j + 1}": _CHANGE * self.noise[j] for j in range(max(robot.n - _WRIST, 1))}
        rows = [[float(name == own) / sigma for name in names] for own, sigma in known.items() if own in names]
        earlier = Earlier(names, np.array(rows)) if rows else None
        own = Goal("a", names, interest=interest, reference=alike, noise=noise, rate=self.rate, paired=True)
        return replace(own, noise_from=self.noise_from, data_length=shape.duration, earlier=earlier, offsets=True)

    def predicted(
        self, robot: Robot, plan: Plan, joints: Sequence[int], sample_rate: float | None = None
    ) -> PayloadSpread:
        """Standard deviations by (17)-(19) of a payload's numbers; constant torques and friction unknown too.

        Torques of the ``joints`` with these numbers count. The motion is looked at at ``sample_rate`` [Hz], twice
        the rate of independent samples if None; of one through points every approach to a pose that it holds is a
        sample, and the arm's constant torques change little.
        """
        if held := isinstance(plan, ViaPoints):
            samples, rate = Samples.at_rest(plan.held), self.rate
        else:
            motion = plan.motion(sample_rate or 2.0 * self.rate)
            samples, rate = Samples.of(motion), motion.rate
        kernel, rows = _payload_kernel(robot), []
        W = kernel.matrix(kernel.state(samples))
        for joint in joints:
            own = W[joint - 1][held | (np.abs(samples.qd[:, joint - 1]) >= _SLOW)]
            if held and joint <= max(robot.n - _WRIST, 1):
                own = np.vstack([own, np.sqrt(_PAIR) / _CHANGE * (np.array(kernel.columns) == f"OFF{joint}")])
            scale = np.sqrt(self.rate / _PAIR / rate) / self.noise[joint - 1]
            rows.append(scale * without(own[:, :10], own[:, 10:]))
        A = np.vstack(rows)
        visibility = visibility_of(A, joints)
        indices, T, b = visibility.resolved(self.mass_sigma is not None)
        known, W = np.array(visibility.base.chosen) == 9, A[:, list(visibility.base.chosen)]
        if self.mass_sigma is not None and known.any():
            W = np.vstack([W, known[None] / self.mass_sigma])  # the scale is one more equation
        root = decomposed(W).root
        C = root @ root.T
        total = T @ C @ T.T + (0.0 if self.mass_sigma is None else np.outer(b, b) * self.mass_sigma**2)
        return payload_spread(self.expected.vector, total, indices)


def assumed_noise(robot: Robot, ratio: float = ASSUMED_RATIO) -> Array:
    """Torque errors where none are told [N·m or N], a ratio of the limits, shape (n,); inf without limits."""
    return ratio * np.array([joint.limits.torque for joint in robot.joints])


def second_pose(
    robot: Robot, shape: NearShape, goal: NearGoal, bounds: JointBounds | None = None, seed: int = 0
) -> Array | None:
    """Find a pose, wrist turned by 90 degrees, that tells clearly more on random motions; None without one."""
    bounds, n = bounds or JointBounds.of(robot), robot.n
    wrist = [j for j in range(max(n - 3, 0), n) if j + 1 in shape.joints and robot.joints[j].revolute]
    steps = np.array([*product((-1.0, 0.0, 1.0), repeat=len(wrist))])
    steps = steps[steps.any(axis=1)]
    pose, candidates = shape.poses[0], np.repeat(shape.poses[:1], len(steps), axis=0)
    candidates[:, wrist] += _APART * steps
    candidates = candidates[((candidates > bounds.low) & (candidates < bounds.high)).all(axis=1)]

    def least(poses: Sequence[Array], looks: int) -> float:
        """Uncertainty of the mass in 10 g or of its centre in mm, after the best of a few random motions."""
        try:
            family = replace(shape, poses=np.array(poses)).family(robot, bounds)
        except InputError:
            return np.inf  # there is no time for them
        draw, rate, seen = np.random.default_rng(seed), min(_LOOKED / shape.duration, 2.0 * goal.rate), []
        for _ in range(looks):
            spread = goal.predicted(robot, family.plan(family.random(draw)), shape.joints, rate)
            numbers = spread.mass / _ALIKE["M"], *(spread.com / _ALIKE["MX"])
            seen.append(max((x for x in numbers if np.isfinite(x)), default=np.inf))
        return min(seen)

    glances = [least([pose, candidate], _GLANCES) for candidate in candidates]
    few = np.argsort(glances, kind="stable")[:_FEW]
    best, k = min(((least([pose, candidates[k]], _LOOKS), int(k)) for k in few), default=(np.inf, 0))
    return candidates[k] if best < _HELPS * least([pose], _LOOKS) else None


def _payload_kernel(robot: Robot) -> RegressorKernel:
    return regressor_kernel(robot.with_offsets(True), (*payload_columns(robot), *friction_columns(robot)))
