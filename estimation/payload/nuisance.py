"""Nuisance torques of a short motion, estimated beside the payload: constant torques, friction and ripple.

Left wholly free, a constant torque takes the weight of a payload for itself where gravity hardly varies, as in ten
seconds of a slow arm. It is what dry friction differs by from one direction to the other, so that its change from
one recording to the next is a fraction of that friction, which the recording without payload shows. It enters as
one more equation for each joint of the arm, and what the change may be widens the intervals; where the recordings
say that it changed more, it is free.

Ripple is periodic in a joint's position. What both recordings have alike goes with their difference; what changes
with the load repeats with the motion: no block of time shows it, and it moves the mass. Waves that a joint's
equations clearly hold are therefore estimated, one after the other, each with all that a slightly wrong wavelength
would leave. Less than one wave over the joint's range is no different from weight and is not looked for.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from msgspec import field
from scipy.special import chdtrc, fdtrc

from ...common import Array, Brief, Document, decomposed, without
from ...model.drives import joint_of
from ..equations.equations import PAYLOAD, Anchor, Equations, merged
from ..equations.observer import Observation, Used, reduced
from ..fit.covariance import inflation, remembered, weighted_solution
from ..fit.linear_problem import Known, SoftPrior
from ..signals.filtering import decimated

FREE = "free "  # beginning of the names of what is estimated anew in each recording, besides the payload
_LEVEL = "held "  # beginning of the names of the values that constant torques have by their prior

OFFSET_SHARE = 0.033
"""Standard deviation of the change between two recordings over a joint's Coulomb friction.

Measured without any payload (benchmarks/constant_torques.py): constant torques of the UR10e's joints 1 to 3
scatter by 2.3 % of it from 10 s to 10 s beyond their noise (90 % interval 1.1 to 4.1 %); the difference of two by
sqrt(2) more.
"""
_WRIST = 3  # last joints, always free: their torque shifts the centre of mass, and the TX40's scatter by 17 %
_CONTRADICTED = 1e-3  # probability of what the recordings say, below which the constant torques are free
_FEWEST_LEFT = 6  # rows of a joint beyond its free columns; fewer may be fitted exactly, and show no errors
_HIDDEN = 1e-6  # fraction of a friction in undetermined directions above which it is not known


def free_columns(columns: Sequence[str]) -> list[str]:
    """Columns that are wholly free in each recording."""
    return [name for name in columns if name.startswith(FREE)]


@dataclass(frozen=True, eq=False, repr=False)
class HeldFriction(Brief):
    """Prior near zero on what is free in each recording."""

    held: Mapping[str, SoftPrior]  # of constant torques and frictions; the others are wholly free
    noise: Array  # of each joint's rows [N·m or N], shape (n,); 0 where too few rows tell it
    memory: Array  # by how much the memory of each joint's errors raises variances, shape (n,)

    @cached_property
    def sigma(self) -> Array:
        """Standard deviations of what constant torques may be [N·m or N], shape (n,); 0 where they are free."""
        roles = (self.held.get(f"OFF{j}") for j in range(1, len(self.noise) + 1))
        return np.array([role.sigma if role else 0.0 for role in roles])

    @property
    def joints(self) -> tuple[int, ...]:
        """Indices of the joints whose constant torques have a prior, from 0."""
        return tuple(np.flatnonzero(self.sigma).tolist())

    @property
    def known(self) -> Known:
        """Values of the prior: zero, as far as sigma says; alike in all recordings, to be safe."""
        k, n = len(self.held), len(self.noise)
        lasting = np.diag([role.sigma**2 for role in self.held.values()])
        names = tuple(f"{_LEVEL}{name}" for name in self.held)
        return Known(names, np.zeros(k), np.zeros((k, k)), lasting, gain_sensitivity=np.zeros((k, n)))

    def friction_free(self, equations: Equations) -> Equations:
        """Take off all that constant torques, friction and ripple of one recording can explain.

        Each prior is one more equation: the friction is its own ``known`` value, as sure as noise and memory allow.
        """
        noise = {name: float(self.noise[joint_of(name)]) for name in self.held}
        anchors = [
            Anchor(f"{FREE}{name}", joint_of(name), noise[name] * role.weight, f"{_LEVEL}{name}")
            for name, role in self.held.items()
        ]
        return equations.eliminate(free_columns(equations.columns), anchors)


def friction_prior(observations: Sequence[Observation], sigmas: Mapping[str, float]) -> HeldFriction:
    """Make the prior of friction near zero with standard deviations by name [N·m or N, or per speed].

    ``observations``: with free columns of each joint, ``PAYLOAD`` and no other, or ``PATH`` besides.
    """
    left = [one.eliminate(free_columns(one.columns)) for one in observations]
    problem = merged(map(reduced, left)).select(PAYLOAD)
    values = weighted_solution(problem)
    noise, spare = problem.error_norms(values) / np.sqrt(np.maximum(problem.rows, 1)), np.array(problem.rows)
    for one in observations:
        free = [one.columns.index(name) for name in free_columns(one.columns)]
        spare = spare - [int(W[:, free].any(axis=0).sum()) for W in one.W]
    noise[spare < _FEWEST_LEFT] = 0.0  # too few rows, beyond the free columns that act on them, to tell it
    memory = np.array(remembered(left, values).inflation)
    held = {name: joint_of(name) for name, sigma in sigmas.items() if sigma > 0.0}
    roles = {name: SoftPrior(sigmas[name], float(memory[j])) for name, j in held.items() if noise[j] > 0.0}
    return HeldFriction(roles, noise, memory)


def offset_prior(observations: Sequence[Observation], coulomb: Array) -> HeldFriction:
    """Make the prior of the arm's constant torques near zero; wholly free where the recordings contradict that.

    ``coulomb``: friction of each joint without payload [N·m or N], shape (n,); 0 where it is not known.
    """
    arm = coulomb[: max(len(coulomb) - _WRIST, 1)].tolist()
    prior = friction_prior(observations, {f"OFF{j}": OFFSET_SHARE * level for j, level in enumerate(arm, start=1)})
    weighty, n = prior.noise * np.sqrt(prior.memory), len(prior.noise)
    weights = np.divide(1.0, weighty, out=np.zeros(n), where=weighty > 0.0)
    free = HeldFriction({}, np.zeros(n), np.ones(n))
    factors = [reduced(one) for one in observations]
    squares = []
    for each in (prior, free):
        left = merged(map(each.friction_free, factors)).select(PAYLOAD).stacked(weights)
        squares.append(float(np.sum(without(left[:, -1:], left[:, :-1]) ** 2)))
    rise, count = max(squares[0] - squares[1], 0.0), len(prior.joints)
    return free if count and chdtrc(count, rise) < _CONTRADICTED else prior


def coulomb_friction(problem: Equations) -> Array:
    """Coulomb friction of each joint [N·m or N], shape (n,); 0 where the motion, or the model, does not show it.

    By recordings without payload in all base parameters, constant torques among them.
    """
    hidden = decomposed(problem.stacked()[:, :-1]).hidden
    every = zip(problem.columns, weighted_solution(problem).tolist(), hidden, strict=True)
    known = {name: max(value, 0.0) for name, value, part in every if part < _HIDDEN}
    return np.array([known.get(f"FS{j}", 0.0) for j in range(1, len(problem.rows) + 1)])


RIPPLE_CHANCE = 0.05  # probability of finding a wave in the noise of one joint in one recording
_FINER = 6  # candidates from one whole wave over the range to the next
_FURTHEST = 40  # waves over the joint's range
_MOST = 4  # waves per joint
_AT_ONCE = 1_000_000  # numbers, so that memory does not grow with the waves
_ROWS_EACH = 20  # rows for each wave: of fewer nothing is looked for
_PASSED = 0.1  # of a wave's amplitude: what decimation leaves less of is not looked for
_DEPENDENT = 0.05  # of a wave's power: explained by the payload but for this, it cannot be separated from it


class Wave(Document, frozen=True):
    """A wave over the turn of a joint in one recording, and the probability of any such wave in noise alone.

    ``joint``: number; ``waves``: [1 per 2 pi rad or 2 pi m]; ``amplitude``: as found alone [N·m or N].
    """

    source: str
    joint: int
    waves: float = field(name="waves_per_turn")
    amplitude: float
    probability_by_noise: float = RIPPLE_CHANCE


def ripple_of(
    source: str, matrices: Sequence[Array], recording: Observation, used: Used
) -> tuple[tuple[Wave, ...], tuple[Array, ...]]:
    """Find waves that the equations of a difference of torques hold besides the payload and what is free.

    ``matrices``: columns of the payload and of what is free, per joint; ``used``: the measurement they come from.

    Returns:
        The waves, and for each joint their columns, r_j x 4 times the largest number of waves of a joint.
    """
    waves, columns = list[Wave](), list[Array]()
    for j, (W, Y, t) in enumerate(zip(matrices, recording.Y, recording.t, strict=True)):
        found = _waves(used, j, W, Y, t)
        columns.append(np.hstack([np.zeros((len(Y), 0)), *(own for *_, own in found)]))
        waves += [Wave(source, j + 1, wave, float(np.sqrt(2.0 * gain / len(Y)))) for wave, gain, _ in found]
    most = max(own.shape[1] for own in columns)
    return tuple(waves), tuple(np.pad(own, ((0, 0), (0, most - own.shape[1]))) for own in columns)


def _waves(used: Used, j: int, W: Array, torque: Array, t: Array) -> list[tuple[float, float, Array]]:
    """Find the clearest wave of a joint, its gain and its columns, then the clearest besides it, ..

    Those are left out that may be the autocorrelated rest.
    """
    (data, keep, decimate), most = used, min(_MOST, len(torque) // _ROWS_EACH)
    position = data.motion.q[:, j] - data.motion.q[:, j].mean()
    span, speed = float(np.ptp(position)), float(np.abs(data.motion.qd[keep[:, j], j]).max(initial=0.0))
    # From one wave over the range to the most that the samples resolve.
    waves = 2.0 * np.pi / max(span, 1e-9) * (1.0 + np.arange(_FINER * (_FURTHEST - 1) + 1) / _FINER)
    waves = waves[waves * speed / data.motion.rate < np.pi]
    if not (most and span and speed and len(waves)):
        return []

    def seen(signals: Sequence[Array]) -> Array:  # as the equations see them
        return np.asarray(decimated(np.array(signals), decimate)[:, keep[::decimate, j]].T)

    def falls(some: Array, Q: Array, left: Array) -> Array:
        """Fall of the sum of squares by each of some waves beside Q; 0 where it hardly stands out."""
        turning = np.outer(some, position)
        pairs = seen([*np.sin(turning), *np.cos(turning)])
        passed = np.sum(pairs**2, axis=0).reshape(2, -1).sum(axis=0) > _PASSED**2 * len(left)
        pairs = _less(pairs, Q).reshape(len(left), 2, -1)
        N, b = np.einsum("riw,rjw->wij", pairs, pairs), np.einsum("riw,r->wi", pairs, left)
        clear = passed & (np.linalg.det(N) > (_DEPENDENT * 0.5 * len(left)) ** 2)
        N[~clear] = np.eye(2)
        return np.where(clear, np.einsum("wi,wij,wj->w", b, np.linalg.inv(N), b), 0.0)

    groups = np.array_split(waves, 1 + len(waves) * len(position) // _AT_ONCE)
    Q, found = decomposed(W).range, list[tuple[float, float, Array]]()
    left = _less(torque, Q)
    while len(found) < most:
        gains = np.concatenate([falls(some, Q, left) for some in groups])
        gain, wave = float(gains.max()), float(waves[np.argmax(gains)])
        if _chance(gain, float(left @ left - gain), len(torque) - Q.shape[1] - 2) * len(waves) > RIPPLE_CHANCE:
            break
        # Sine and cosine of a wave, and their slopes by the wavelength, which is not known exactly.
        shapes = [np.sin(wave * position), np.cos(wave * position)]
        found.append((wave, gain, seen([*shapes, *(wave * position * shape for shape in shapes)])))
        Q = decomposed(np.column_stack([Q, found[-1][2]])).range
        left = _less(torque, Q)
    rest, spare = inflation([(t, left)]) * float(left @ left), len(torque) - Q.shape[1]
    return [wave for wave in found if _chance(wave[1], rest, spare) * len(waves) <= RIPPLE_CHANCE]


def _chance(gain: float, rest: float, spare: int) -> float:
    """Probability that white noise lowers the sum of squares to ``rest`` by as much (F test)."""
    return float(fdtrc(2, spare, 0.5 * gain / rest * spare)) if spare > 0 and rest > 0.0 else 1.0


def _less(columns: Array, Q: Array) -> Array:
    return np.asarray(columns - Q @ (Q.T @ columns))
