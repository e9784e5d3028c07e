"""Standard deviations of mass, centre of mass and inertia there, from those of Khalil's ten."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..common.arrays import Array
from .inertia import gradients


@dataclass(frozen=True)
class PayloadSpread:
    """Standard deviations; infinite where a number is not determined.

    Attributes:
        mass: [kg].
        com: of the centre of mass [m], shape (3,).
        inertia_com: of the inertia at the centre of mass [kg m^2], 3 x 3.
    """

    mass: float
    com: Array
    inertia_com: Array

    @property
    def moments(self) -> Array:
        """Of the three moments of inertia [kg m^2], shape (3,)."""
        return np.diag(self.inertia_com).copy()


def payload_spread(values: Array, covariance: Array, places: Sequence[int]) -> PayloadSpread:
    """Standard deviations of a body's numbers to first order, by the full covariance.

    Args:
        values: the ten, shape (10,); those that are not determined are not used.
        covariance: of the determined ones, k x k.
        places: which of the ten they are, k.
    """
    C = np.zeros((10, 10))
    C[np.ix_(places, places)] = covariance
    x = np.zeros(10)
    x[list(places)] = values[list(places)]
    known = set(places)
    if 9 not in known or x[9] == 0.0:
        mass = float(np.sqrt(C[9, 9])) if 9 in known else np.inf
        return PayloadSpread(mass, np.full(3, np.inf), np.full((3, 3), np.inf))
    com, inertia = np.full(3, np.inf), np.full((3, 3), np.inf)
    sigma = np.sqrt(np.maximum(np.einsum("ik,kl,il->i", J := gradients(x), C, J), 0.0))
    for k in range(3):
        if 6 + k in known:
            com[k] = sigma[k]
    for place, (i, j) in enumerate(zip(*np.triu_indices(3), strict=True)):
        needed = {place, *({6, 7, 8} - {6 + int(i)} if i == j else {6 + int(i), 6 + int(j)})}
        if needed <= known:
            inertia[i, j] = inertia[j, i] = sigma[3 + place]
    return PayloadSpread(float(np.sqrt(C[9, 9])), com, inertia)
