"""A hose or cable at the flange: a force that changes linearly with place, in all recordings or in some.

Towards a fixed anchor it is F = c - k p, p the flange's place. Four more columns of method 4 on thinned states:
J'p, that of the stiffness k, and J'e along three axes for the constant c. A constant pull upwards differs from a
lighter payload by the payload's inertia alone: a slow motion leaves it open, and the mass with it.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...model import Robot
from ...model.many_states import point_at
from .nuisances import WITH_PAYLOAD, Nuisance, Tilt, horizontal, parts
from .thinned import Asked, Thinned

PULL, PULL_Z, ALONG_Z = 0.025, 7.0, 4.5
"""Force over the payload's weight, and standard deviations of it, above which something pulls.

The last: of stiffness and upward force with payload alone, if the stiffness pulls. What a model leaves of a real
arm shows least there, up to 2.8; a force to the side with payload up to 4.8, stiffness in all recordings up to 5.7.
"""
CLEARER = 1.2
"""So many times what a tilt, a delay or a slip takes off is taken off by a pull.

A tilted base looks like a force to the side, which takes off as much at most (1.01); a spring that pulls to the
side takes off 1.4 times as much as a tilt, and more.
"""
_ALONG, _ACROSS = [0, 3], [1, 2]
"""Places of stiffness and upward force, and of the horizontal one: a hose from above shows in the first two."""


class Pull(NamedTuple):
    """A force at the flange.

    ``values``: stiffness [N/m] and the constant force [N] along two horizontal axes and upwards, (4,), with
    ``covariance``; ``effect``: on the payload's ten once it is corrected, 10 x 4; ``force``: its size over the
    motion (rms), over the payload's weight; ``fall``: share of the squared residual that it takes off; ``where``:
    in which recordings, as of a nuisance.
    """

    values: Array
    covariance: Array
    effect: Array
    force: float
    fall: float
    where: str = WITH_PAYLOAD

    @property
    def z(self) -> float:
        """Standard deviations from none: of stiffness and upward force together, or of the horizontal force."""
        return max(self._z(_ALONG), self._z(_ACROSS))

    def _z(self, places: list[int]) -> float:
        own = self.covariance[np.ix_(places, places)]
        if not np.isfinite(own).all():
            return 0.0
        square = float(self.values[places] @ np.linalg.pinv(own, hermitian=True) @ self.values[places])
        return float(np.sqrt(max(square, 0.0)))

    @property
    def stands_out(self) -> bool:
        """Whether it is more than chance and a model's own errors show; no hose pushes away from where it ends."""
        pulling = self.where == WITH_PAYLOAD and self.values[0] > 0.0
        along = pulling and self._z(_ALONG) > ALONG_Z
        return self.force > PULL and (along or self.z > PULL_Z)

    @property
    def sideways(self) -> float:
        """Size of the constant horizontal force [N]."""
        return float(np.linalg.norm(self.values[_ACROSS]))

    @property
    def change(self) -> Array:
        """Change of the payload's ten by correcting it, (10,)."""
        return np.asarray(self.effect @ self.values)

    @property
    def mass_sigma(self) -> float:
        """Standard deviation of the mass's change [kg]; nan where nothing shows a part of the force."""
        return float(np.sqrt(self.effect[9] @ self.covariance @ self.effect[9]))


def pulls(system: Thinned) -> tuple[Pull, ...]:
    """What pulls at the flange in all recordings, or in those without or with payload."""
    robot, loaded = system.robot, system.states.loaded
    place, moved = point_at(robot, flange(robot), system.states.sample.q)
    axes = upright(robot)
    columns = np.stack([np.einsum("ajn,an->jn", moved, place), *np.einsum("ajn,ka->kjn", moved, -axes)], axis=1)
    shares = parts(loaded)
    question = system.with_columns(np.concatenate([columns * share for _, share in shares], axis=1))
    weight = float(np.abs(system.values[system.payload][9:]).sum()) * float(np.linalg.norm(robot.gravity))
    return tuple(
        _pull(question, 4 * k, where, (axes, place[:, share > 0.0], weight))
        for k, (where, share) in enumerate(shares)
    )


def _pull(question: Asked, first: int, where: str, at: tuple[Array, Array, float]) -> Pull:
    """That of four columns; ``at``: upright axes, places of the flange [m], and the payload's weight [N]."""
    axes, place, weight = at
    columns = (first, first + 1, first + 2, first + 3)
    answer = question.of(*columns)
    acting = (answer.values[1:] @ axes)[:, None] - answer.values[0] * place
    force = float(np.sqrt(np.mean(np.sum(acting**2, axis=0)))) / max(weight, 1e-300)
    return Pull(answer.values, answer.covariance, answer.effect, force, question.fall(*columns), where)


def outstanding(system: Thinned, leaning: Tilt | None, others: Sequence[Nuisance]) -> tuple[Pull, ...]:
    """The pull that explains most, of those that stand out and explain more than a tilt, a delay and a slip."""
    rivals = [leaning.fall if leaning is not None else 0.0, *(nuisance.fall for nuisance in others)]
    acting = [pull for pull in pulls(system) if pull.stands_out and pull.fall > CLEARER * max(rivals)]
    return (max(acting, key=lambda pull: pull.fall),) if acting else ()


def flange(robot: Robot) -> Array:
    """The flange in frame n [m]; the origin of the payload's frame where it is not known."""
    origin = np.array(robot.flange.origin)
    if robot.flange_pose is None:
        return origin
    return np.asarray(origin + np.array(robot.flange.rotation) @ np.array(robot.flange_pose.origin))


def upright(robot: Robot) -> Array:
    """Two horizontal axes and the one upwards; those of the base where there is no gravity."""
    g = np.array(robot.gravity)
    if not g.any():
        return np.eye(3)
    rows = np.array([*horizontal(g), -g])
    return np.asarray(rows / np.linalg.norm(rows, axis=1)[:, None])
