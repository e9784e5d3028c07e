"""Score of a motion: how much it would teach, and how near it comes to its limits: exact sign, fine grid."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...common import Array, Brief, InputError, decomposed
from ...common.linear import condition_numbers
from ...model import Motion, inverse_dynamics, standard_columns
from ...model.kernel.kernel import Kernel
from ..motions.family import Samples
from .limits import LimitCheck, State, check, excess, state_limits
from .problem import DesignProblem

FINER = 10  # ratio of the final check's grid to the optimisation's
TOLERANCE = 1e-9  # miss of a limit, in its own units, up to which it is met


class Learnt(NamedTuple):
    """Information that data give of a goal's parameters."""

    log_det: float  # log det of the information matrix (d) by the best weights; -inf if it is singular
    condition_number: float  # of W in SI units, rows unweighted; inf if W has not full rank
    condition_number_scaled: float  # of W with its columns scaled to norm 1
    sigma: dict[str, float]  # predicted standard deviation of each parameter; inf if W has not full rank
    # of the parameters in the order of ``sigma``, by the weights (16) of an estimate; None if W has not full rank
    covariance: Array | None = None

    def relative_sigma(self, reference: Mapping[str, float]) -> dict[str, float]:
        """Predicted standard deviations relative to reference values other than zero."""
        return {name: sigma / abs(reference[name]) for name, sigma in self.sigma.items() if reference.get(name)}


@dataclass(frozen=True, eq=False, repr=False)
class Score(Brief):
    """Score of a motion, whatever the criterion it was designed for.

    Attributes:
        value: of the goal's criterion without surrogate, for one second of data or the goal's data length: small
            is good.
        problem: by whose goal and limits it was judged.
    """

    value: float
    limits: tuple[LimitCheck, ...]
    problem: DesignProblem
    samples: Samples

    @property
    def duration(self) -> float:
        """Duration of the motion [s]."""
        return float(self.samples.weight.sum())

    @cached_property
    def learnt(self) -> Learnt:
        """Information of the ideal motion and the earlier recordings, where these are in the weights needed."""
        state = self.problem.exact(self.samples)
        W = self.problem.kernel.dense(state.entries)[:, :, self.problem.places]
        return learnt_of(self.problem, list(W), [self.samples.weight / self.duration] * len(W), self.duration)

    @property
    def max_violation(self) -> float:
        """Largest violation of a limit, in units of the limit; 0 if all are met."""
        return max((limit.relative for limit in self.limits), default=0.0)

    @property
    def feasible(self) -> bool:
        """True if all limits are met."""
        return self.max_violation <= TOLERANCE

    @property
    def violations(self) -> tuple[str, ...]:
        """Describe each limit that is not met, one line each."""
        return tuple(str(limit) for limit in self.limits if limit.relative > TOLERANCE)


def learnt_of(problem: DesignProblem, W: Sequence[Array], parts: Sequence[Array], duration: float) -> Learnt:
    """Compute what each joint's rows, each for its part of the time, teach with the earlier recordings."""
    with_earlier, recorded = problem.criterion.weighted, problem.goal.single_rate
    recorded *= problem.goal.data_length or duration
    used = np.isfinite(problem.noise)
    rows = [np.sqrt(recorded * part)[:, None] * own for own, part in zip(W, parts, strict=True)]
    weighted = [own / sigma for own, sigma in zip(rows, problem.noise, strict=True)]
    earlier = problem.earlier if with_earlier else problem.earlier[:0]
    plain = np.vstack([*rows, *([] if with_earlier else [problem.earlier])])
    R = decomposed(np.asarray(np.linalg.qr(np.vstack([*weighted, earlier]), mode="r")))
    if R.rank < len(problem.names):
        return Learnt(-np.inf, *condition_numbers(plain), dict.fromkeys(problem.names, np.inf))
    # An estimate weighs joints by what ordinary least squares leave (16), which spread the errors of strong joints
    # over weak ones: no best weights where their noise is far apart.
    root = R.rowspace / R.singular / R.sizes[:, None]
    grams = np.array([(own @ root).T @ (own @ root) for own, use in zip(rows, used, strict=True) if use])
    square, count = problem.noise[used] ** 2, recorded * np.array([*map(np.sum, parts)])[used]
    ordinary, prior = np.linalg.pinv(grams.sum(axis=0), hermitian=True), (earlier @ root).T @ (earlier @ root)
    spread = ordinary @ np.einsum("j,jab->ab", square, grams) @ ordinary
    left = square + np.einsum("ab,jab->j", spread, grams) / np.maximum(count, 1e-300)
    shown, wrong = (np.einsum("j,jab->ab", each, grams) + prior for each in (1.0 / left, square / left**2))
    root = root @ np.linalg.inv(shown)
    covariance = np.asarray(root @ wrong @ root.T)
    sigma = dict(zip(problem.names, np.sqrt(np.diag(covariance)).tolist(), strict=True))
    log_det = 2.0 * float(np.log(R.singular).sum() + np.log(R.sizes).sum())
    return Learnt(log_det, *condition_numbers(plain), sigma, covariance)


def score_motion(problem: DesignProblem, motion: Motion) -> Score:
    """Judge any motion by a problem's goal and limits, such as one read back from a log."""
    return score_samples(problem, Samples.of(motion))


def holding_torques(problem: DesignProblem, poses: Array) -> Array:
    """Largest torque [N·m or N] of each joint that holds the arm at poses (N, n), of all loads; shape (n,).

    It is what brakes have to hold when power is cut there. Zero without torque limits.
    """
    state, n = problem.at_rest(poses), problem.robot.n
    torques = [np.abs(limit.values(state) * limit.unit).reshape(-1, n) for limit in problem.of_kind("torque")]
    return np.asarray(np.vstack([np.zeros((1, n)), *torques]).max(axis=0))


def check_held(problem: DesignProblem, poses: Array) -> None:
    """Refuse poses (N, n) in which a load breaks a torque limit at rest."""
    state = problem.at_rest(poses)
    for holding in (check(limit, state) for limit in problem.of_kind("torque")):
        if holding.violation > 0.0:
            raise InputError(
                f"at rest in the pose: {holding.name} of {holding.worst} is {holding.value:.4g} against "
                f"{holding.limit:.4g}: choose another pose, or a lighter payload"
            )


def room_over_time(problem: DesignProblem, motion: Motion) -> Array:
    """Room of each joint to its nearest limit, (N, n), in units of the limit; positions: of half the range."""
    state, limits = problem.exact(Samples.of(motion)), (*state_limits(problem.bounds), *problem.of_kind("torque"))
    rooms = [-excess(limit, limit.values(state)).reshape(len(motion.t), -1, problem.robot.n) for limit in limits]
    return np.asarray(np.concatenate(rooms, axis=1).min(axis=1))


def taught_over_time(problem: DesignProblem, motion: Motion) -> Array:
    """Fraction of the information in each sample of a motion, (N,): the trace of the hat matrix, by samples."""
    state = problem.exact(Samples.of(motion))
    rows = _rows(problem, state, problem.row_weights(state.samples, True), False)
    return np.asarray((decomposed(rows).range ** 2).sum(axis=1).reshape(problem.robot.n, -1).sum(axis=0))


def load_torques(problem: DesignProblem, motion: Motion) -> dict[str, Array]:
    """Torques on a motion [N·m or N], (N, n), by the name of each load that the design reckons with.

    They are those of the torque limits; without any, those of the description's parameters; nothing without these.
    """
    n, torques = motion.q.shape[1], {}
    if problem.torque_limited:
        state = problem.exact(Samples.of(motion))
        for limit in problem.of_kind("torque"):
            torque = limit.values(state) * limit.unit
            if torque.shape[1] == n:
                torques[limit.name] = torque
            else:  # the limit stands for many payloads
                torques |= {f"largest {limit.name}": torque[:, :n], f"smallest {limit.name}": torque[:, n:]}
        return torques
    known, names = problem.robot.parameters, standard_columns(problem.robot)
    if not all(name in known for name in names):
        return {}
    dynamics, torque = Kernel(inverse_dynamics(problem.robot)), np.zeros(motion.q.shape)
    chi = np.array([known[name] for name in names])
    torque[:, dynamics.rows] = dynamics(motion.q, motion.qd, motion.qdd, chi).T
    return {"torque": torque}


def score_of(problem: DesignProblem, x: Array) -> Score:
    """Judge a motion of the problem's family on the fine grid."""
    return score_samples(problem, problem.family.sample(x, FINER))


def score_samples(problem: DesignProblem, samples: Samples) -> Score:
    """Judge samples of a motion."""
    state, kind = problem.exact(samples), problem.criterion.kind
    weights = problem.row_weights(samples, problem.criterion.weighted)
    if kind in ("cond", "cond-scaled"):
        value = float(np.log(condition_numbers(_rows(problem, state, weights, True))[kind == "cond-scaled"]))
    else:
        value = problem.criterion(problem.information(state.entries, weights), problem.criterion.orders[-1])[0]
    return Score(value, tuple(check(limit, state) for limit in problem.limits), problem, samples)


def _rows(problem: DesignProblem, state: State, weights: Array, earlier: bool) -> Array:
    """Rows whose Gram matrix is the information: the motion's, then the earlier recordings'."""
    W = problem.kernel.dense(state.entries)[:, :, problem.places] * np.sqrt(weights)[:, :, None]
    rows = W.reshape(-1, W.shape[2])
    return np.vstack([rows, problem.earlier]) if earlier else rows
