"""Random motions of every class, each as fast as all limits allow: what a design has to beat."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from dynident.common.arrays import Array
from dynident.trajectories import DesignProblem, FourierShape, ViaPointShape
from dynident.trajectories.design.limits import excess
from dynident.trajectories.design.score import FINER, TOLERANCE
from dynident.trajectories.motions.fourier import FreeSeries
from dynident.trajectories.motions.via_points import FreeViaPoints
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline

_SCALES = np.geomspace(4.0, 0.1, 40)  # of speed: tried from the fastest
_HALVINGS = 10  # of the step between the last that is too fast and the first that is not
_POINTS, _HARMONICS, _PERIOD = 14, 5, 10.0


class Rival(NamedTuple):
    """A random motion x of a family."""

    family: FreeViaPoints | FreeSeries
    x: Array


Drawn = tuple[int, Callable[[Array], Rival]]
"""Number of parts whose speeds are found for themselves, and the motion by their speeds."""


def at_rest(like: DesignProblem, draw: np.random.Generator) -> Drawn:
    """Random via points, at rest in each; every segment by itself is as fast as its limits allow."""
    family = ViaPointShape(_POINTS, passing=False).family(like.robot, like.bounds)
    x, own = family.random(draw), family.size - (_POINTS - 1)
    return _POINTS - 1, lambda speeds: Rival(family, np.append(x[:own], x[own:] - np.log(speeds)))


def passing(like: DesignProblem, draw: np.random.Generator) -> Drawn:
    """A quintic spline through random via points, from rest to rest, drawn in to the position limits."""
    family = ViaPointShape(_POINTS).family(like.robot, like.bounds)
    n, bounds = like.robot.n, like.bounds
    start = family.random(draw)
    points, times = start[: _POINTS * n].reshape(-1, n), np.exp(start[1 - _POINTS :])
    rest = [(1, np.zeros(n)), (2, np.zeros(n))]
    t = np.concatenate([[0.0], np.cumsum(times)])
    curve = make_interp_spline(t, bounds.middle + bounds.half * points, k=5, bc_type=(rest, rest))
    far = (curve(np.linspace(0.0, t[-1], 1000)) - bounds.middle) / bounds.half
    inwards = min(1.0, 0.999 / float(np.abs(far).max()))

    def timed(speeds: Array) -> Rival:
        (speed,) = speeds
        v = speed * curve(t[1:-1], 1) / bounds.speed
        a = speed**2 * curve(t[1:-1], 2) / bounds.acceleration
        shape = inwards * np.concatenate([points.ravel(), v.ravel(), a.ravel()])
        return Rival(family, np.concatenate([shape, np.log(times / speed)]))

    return 1, timed


def quick_fourier(like: DesignProblem, draw: np.random.Generator) -> Drawn:
    """Fourier series that use half of the position range, in the shortest period that the limits allow."""
    family = FourierShape(_HARMONICS, _PERIOD).family(like.robot, like.bounds)
    c = family.random(draw).reshape(like.robot.n, -1)
    reach = np.abs(family.sample(c.ravel()).q - like.bounds.middle - like.bounds.half * c[:, -1:].T).max(axis=0)
    c[:, :-1] *= (0.5 * like.bounds.half / reach)[:, None]

    def timed(speeds: Array) -> Rival:
        x = c.copy()
        x[:, :-1] *= speeds[0]
        shape = FourierShape(_HARMONICS, _PERIOD / float(speeds[0]))
        return Rival(shape.family(like.robot, like.bounds), x.ravel())

    return 1, timed


CLASSES = {"14 points at rest": at_rest, "14 points passing": passing, "Fourier, shortest period": quick_fourier}


def random_motions(like: DesignProblem, kind: str, count: int, seed: int) -> list[Rival]:
    """So many random motions of a class, each as fast as the limits allow on the solver's fine grid."""
    draw, rivals = np.random.default_rng(seed), list[Rival]()
    while len(rivals) < count:
        parts, timed = CLASSES[kind](like, draw)

        def kept(speeds: Array, timed: Callable[[Array], Rival] = timed, parts: int = parts) -> NDArray[np.bool_]:
            rival = timed(speeds)
            samples = rival.family.sample(rival.x, FINER)
            state = like.kernel.state(samples)
            over = [excess(limit, limit.values(state)).reshape(parts, -1).max(axis=1) for limit in like.limits]
            return np.asarray(np.max(over, axis=0)) <= TOLERANCE

        speeds = _fastest(kept, parts)
        rivals += [] if speeds is None else [timed(speeds)]
    return rivals


def _fastest(within_limits: Callable[[Array], NDArray[np.bool_]], parts: int) -> Array | None:
    """The largest scale of each part that keeps the limits; None if a part has none."""
    good, has_scale = np.zeros(parts), np.zeros(parts, dtype=bool)
    for scale in _SCALES:
        new = within_limits(np.where(has_scale, good, scale)) & ~has_scale
        good[new], has_scale = scale, has_scale | new
        if has_scale.all():
            break
    if not has_scale.all():
        return None
    bad = good * _SCALES[0] / _SCALES[1]
    for _ in range(_HALVINGS):
        middle = np.sqrt(good * bad)
        fits = within_limits(middle)
        good, bad = np.where(fits, middle, good), np.where(fits, bad, middle)
    return good
