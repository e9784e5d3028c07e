"""Estimates of a payload to be constrained, made or published."""

import numpy as np
from dynident.common.arrays import Array
from dynident.estimation import PAYLOAD, CentreOfMassInBox, Estimate, InEllipsoid, KnownMass, MassBounds
from dynident.estimation.fit.estimate import Fit
from dynident.estimation.possible.constraints import Constraint
from dynident.examples.paper.printed import Printed, paper_tables
from dynident.model import Processing

NOTHING = Fit(np.ones(1), np.ones(1), (1,))
EXACT = Processing()


def estimate_of(values: Array, covariance: Array, names: tuple[str, ...] = PAYLOAD) -> Estimate:
    return Estimate(names, values, covariance, np.inf, NOTHING, np.ones(1))


def random_estimate(seed: int) -> Estimate:
    """Grams to tonnes, millimetres to metres, every second one a thin body; errors of 0.1 to 30 %, correlated."""
    draw = np.random.default_rng(seed)
    mass, length = 10.0 ** draw.uniform(-3, 3), 10.0 ** draw.uniform(-3, 0.5)
    points = draw.uniform(-1.0, 1.0, (3 + 3 * (seed % 2), 3)) * length
    second = points.T @ points * mass / len(points)
    inertia = np.trace(second) * np.eye(3) - second
    moments = mass * points.mean(axis=0)
    truth = np.concatenate([inertia[np.triu_indices(3)], moments, [mass]])
    size = np.array([mass * length**2] * 6 + [mass * length] * 3 + [mass])
    root = 10.0 ** draw.uniform(-3, -0.5) * size[:, None] * draw.standard_normal((10, 12)) / np.sqrt(12)
    return estimate_of(truth + root @ draw.standard_normal(12), root @ root.T)


def printed(rows: dict[str, Printed]) -> Estimate:
    """A published table; its sigma taken as independent."""
    sigma = np.array([row.two_sigma / 2.0 for row in rows.values()])
    values = np.array([row.value for row in rows.values()])
    return estimate_of(values, np.diag(sigma**2), tuple(f"{kind}_L" for kind in rows))


def all_ten(estimate: Estimate) -> Array:
    values = np.zeros(10)
    values[[PAYLOAD.index(name) for name in estimate.names]] = estimate.values
    return values


TABLES = {1: printed(paper_tables().table1), 2: printed(paper_tables().table2)}
ELLIPSOID = InEllipsoid([0.0, 0.0, 0.1], [0.1, 0.08, 0.09])
SETS: dict[str, list[Constraint]] = {
    "possible": [],
    "mass bounds": [MassBounds(7.1, 7.19)],
    "weighed": [KnownMass(7.18, 0.01)],
    "centre of mass": [CentreOfMassInBox([-0.1, -0.1, 0.0], [0.1, 0.1, 0.134])],
    "ellipsoid": [ELLIPSOID],
    "together": [MassBounds(7.1, 7.19), KnownMass(7.18, 0.01), ELLIPSOID, CentreOfMassInBox([-1] * 3, [1] * 3)],
}
