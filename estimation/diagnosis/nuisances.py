"""What may lie beside robot and payload in the torques: a tilted base, a delay, a slip.

Each is one or a few more columns of method 4 on thinned states. A tilt is a nuisance: one that stands out is taken
out of the payload, and what the recordings leave open of it is in the interval.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...model import INERTIAL, Robot
from ...model.many_states import regressor_at
from ...model.names import parameter_kind
from ...model.regressors import payload_columns
from ..payload.result import frame_change
from .states import STRETCH
from .thinned import Asked, Thinned

LEVEL = np.radians(1.0)
"""rad: standard deviation of a base's tilt about either horizontal axis, as mounted arms have it."""
_UPRIGHT = 1e-9
"""Sine of the angle between the first axis and gravity below which they are parallel."""
TILT, TILT_Z = np.radians(0.5), 5.0
"""rad and standard deviations of a tilt above which it is taken out of the payload and told; smaller ones widen the
intervals without a word."""
BURST = 3.0
"""Mean squared residual of a stretch over their median, above which the stretch is left out."""
FEWEST = 12
"""Stretches of which a median says something."""
WITH_PAYLOAD = " with payload"
WHERE = ("", " without payload", WITH_PAYLOAD)
"""Of which recordings: all, or some."""


class Nuisance(NamedTuple):
    """Something else in the torques.

    ``kind``: "late" or "slip"; ``where``: one of ``WHERE``; ``size`` [s or m] with its
    standard deviation ``sigma``; ``z``: standard deviations from zero; ``change``: of the payload's ten once it
    is corrected, (10,); ``fall``: share of the squared residual that it takes off.
    """

    kind: str
    where: str
    size: float
    sigma: float
    z: float
    change: Array
    fall: float = 0.0


class Bursts(NamedTuple):
    """Stretches of time whose residuals stand out.

    ``many`` of ``stretches`` of ``length`` [s]; ``change``: of the payload's ten without them, (10,).
    """

    many: int
    stretches: int
    length: float
    change: Array


class Tilt(NamedTuple):
    """How far gravity leans about two horizontal axes.

    ``values``: as seen [rad], (2,); ``covariance``; ``effects``: on the ten by method 4 and by method 3,
    each 10 x 2; ``fall``: share of the squared residual that it takes off.
    """

    values: Array
    covariance: Array
    effects: tuple[Array, Array]
    fall: float = 0.0

    @property
    def angle(self) -> float:
        """Altogether [rad]."""
        return float(np.linalg.norm(self.values))

    @property
    def z(self) -> float:
        """Standard deviations from none."""
        return float(np.sqrt(self.values @ np.linalg.solve(self.covariance, self.values)))

    @property
    def sigma(self) -> float:
        """Standard deviation of the angle [rad]."""
        along = self.values / max(self.angle, 1e-300)
        return float(np.sqrt(along @ self.covariance @ along))

    @property
    def stands_out(self) -> bool:
        """Whether it is more than mountings have, and than chance shows."""
        return self.angle > TILT and self.z > TILT_Z

    def change(self, method: int) -> tuple[Array, Array]:
        """Change of the ten by correcting a tilt that stands out, as far as it is believed, and its covariance.

        A tilt that does not stand out is left in the ten: the covariance then holds its mean square.
        """
        effect, inverse = self.effects[method == 3], np.linalg.inv(self.covariance)
        variance = np.linalg.inv(inverse + np.eye(2) / LEVEL**2)
        mean = variance @ inverse @ self.values
        if not self.stands_out:
            return np.zeros(len(effect)), effect @ (variance + np.outer(mean, mean)) @ effect.T
        return effect @ mean, effect @ variance @ effect.T


def tilt(system: Thinned) -> Tilt | None:
    """How far gravity leans; None where there is none, or the motion shows nothing of it."""
    if not any(system.robot.gravity):
        return None
    own, heavy, free = _leaning(system)
    question = system.with_columns(np.concatenate([own + heavy, free], axis=1))
    moments = tuple(range(2, 2 + free.shape[1]))
    answer = question.of(0, 1, beside=moments)
    if not (np.diag(answer.covariance) > 0.0).all():
        return None
    alone = system.of_difference().with_columns(heavy).of(0, 1) if system.states.loaded.any() else answer
    fall = question.fall(0, 1, beside=moments)
    return Tilt(answer.values, answer.covariance, (answer.effect, alone.effect), fall)


def _leaning(system: Thinned) -> tuple[Array, Array, Array]:
    """Torques by 1 rad of tilt about two axes, of the robot and of the payload, and what is free; n x k x N.

    Where the first axis is along gravity, first moments about it show in a tilt alone: they are free.
    """
    robot, sample, states = system.robot, system.states.sample, system.states
    rigid = [k for k, name in enumerate(system.names) if parameter_kind(name) in INERTIAL]
    load = payload_columns(robot) if states.loaded.any() else ()
    first = ("MX1", "MY1") if _upright(robot) else ()
    names = tuple(dict.fromkeys([*(system.names[k] for k in rigid), *load, *first]))
    still, g = np.zeros(sample.q.shape), np.array(robot.gravity)
    own, heavy, free = [], [], list[Array]()
    ten = frame_change(robot.flange) @ system.values[system.payload] if load else np.zeros(0)
    for across in horizontal(g):
        leaning = replace(robot, gravity=(float(across[0]), float(across[1]), float(across[2])))
        W = regressor_at(leaning, names, sample.q, still, still)
        own.append(np.einsum("jcn,c->jn", W[:, : len(rigid)], system.values[rigid]))
        heavy.append(np.einsum("jcn,c->jn", W[:, [names.index(name) for name in load]], ten) * states.loaded)
        free = free or [W[:, names.index(name)] for name in first]
    nothing = np.zeros((robot.n, 0, len(states.loaded)))
    return np.stack(own, axis=1), np.stack(heavy, axis=1), np.stack(free, axis=1) if free else nothing


def horizontal(g: Array) -> tuple[Array, Array]:
    """Two vectors as long as gravity, across it and each other."""
    length = float(np.linalg.norm(g))
    first = np.cross(g, np.eye(3)[int(np.argmin(np.abs(g)))])
    first *= length / float(np.linalg.norm(first))
    return first, np.cross(g, first) / length


def _upright(robot: Robot) -> bool:
    """Whether the first joint turns about gravity."""
    joint, g = robot.joints[0], np.array(robot.gravity)
    axis = np.array([0.0, -np.sin(joint.alpha), np.cos(joint.alpha)])
    return joint.revolute and float(np.linalg.norm(np.cross(axis, g))) < _UPRIGHT * float(np.linalg.norm(g))


def nuisances(system: Thinned) -> tuple[Nuisance, ...]:
    """Nuisances that stand out most, one of each kind."""
    loaded = system.states.loaded
    slope = system.states.slope.T
    shares = parts(loaded)
    columns = [slope * share for _, share in shares]
    late = (np.cumsum(loaded) > 0.5 * loaded.sum()) * loaded
    moved = system.columns[:, system.payload][:, 6:9] * late
    question = system.with_columns(np.concatenate([np.stack(columns, axis=1), moved], axis=1))
    delay = _late(question, [where for where, _ in shares])
    if not loaded.any() or not system.values[system.payload][9] > 0.0:
        return (delay,)
    return (delay, _slip(question, len(shares), system.values[system.payload][9]))


def parts(loaded: Array) -> list[tuple[str, Array]]:
    """All states, those without and those with payload, in words and as 1 or 0; where all are alike, these."""
    if loaded.all():
        return [(WITH_PAYLOAD, loaded)]
    shares = np.ones(len(loaded)), 1.0 - loaded, loaded
    return list(zip(WHERE, shares if loaded.any() else shares[:1], strict=False))


def _late(question: Asked, there: list[str]) -> Nuisance:
    """The delay in the recordings in which it stands out most."""
    answers = [(where, question.of(place), question.fall(place)) for place, where in enumerate(there)]
    where, answer, fall = max(answers, key=lambda entry: entry[1].z)
    sigma = float(np.sqrt(answer.covariance[0, 0]))
    return Nuisance("late", where, -float(answer.values[0]), sigma, answer.z, answer.effect @ answer.values, fall)


def _slip(question: Asked, first: int, mass: float) -> Nuisance:
    """A step of the centre of mass, three columns from ``first`` on."""
    places = range(first, first + 3)
    answer = question.of(*places)
    size = float(np.linalg.norm(answer.values) / mass)
    sigma = float(np.sqrt(np.trace(answer.covariance)) / mass)
    change = answer.effect @ answer.values
    return Nuisance("slip", WITH_PAYLOAD, size, sigma, answer.z, change, question.fall(*places))


def bursts(system: Thinned) -> Bursts | None:
    """Stretches of 3 s whose mean squared residual is over 3 times the median, and the payload without them.

    None where there are none, or more than half, or few stretches altogether.
    """
    many, stretches, change = system.without_stretches(BURST)
    if not many or 2 * many > stretches or stretches < FEWEST:
        return None
    return Bursts(many, stretches, STRETCH, change)
