"""Each constraint: bodies that hold it pass, bodies that break it fail, and texts say what is demanded."""

from collections.abc import Callable

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.estimation import CentreOfMassInBox, InEllipsoid, KnownMass, MassBounds, PossibleBody
from dynident.estimation.possible.constraints import Constraint
from dynident.model import InertialParameters
from dynident.model.inertia import ten_parameters

Cloud = Callable[[Array, Array], InertialParameters]
ROTATION = np.linalg.qr(np.random.default_rng(5).standard_normal((3, 3)))[0]
CENTRE, SEMI_AXES = np.array([0.05, -0.1, 0.2]), np.array([0.1, 0.2, 0.3])


def test_possible_body_is_the_pseudo_inertia(random_bodies: Callable[[int, int], list[InertialParameters]]) -> None:
    rule = PossibleBody("gripper")
    for body in random_bodies(50, 3):
        assert rule.violation(body.vector) < 0.0


def test_positive_inertia_is_not_enough() -> None:
    """All principal inertias positive, the triangle inequality broken by 0.01 kg m^2."""
    impossible = ten_parameters(2.0, np.array([0.1, 0.0, 0.2]), np.diag([0.01, 0.02, 0.04]))
    rule = PossibleBody("gripper")
    assert rule.violation(impossible) > 0.0


@pytest.mark.parametrize("unit", range(10))
def test_possible_body_sees_every_parameter(unit: int) -> None:
    """No single parameter can be negative where all others are zero."""
    x = np.zeros(10)
    x[unit] = -0.1
    assert PossibleBody().violation(x) > 0.0


def test_mass_bounds() -> None:
    x = 2.0 * np.eye(10)[9]
    assert MassBounds(1.0, 3.0).violation(x) == pytest.approx(-1.0)
    assert MassBounds(2.5).violation(x) == pytest.approx(0.5)
    assert MassBounds(high=1.5).violation(x) == pytest.approx(0.5)


def test_known_mass_is_soft() -> None:
    rule = KnownMass(2.0, 0.1)
    assert rule.violation(2.4 * np.eye(10)[9]) < 0.0
    assert not len(rule.rows[0])


def test_centre_of_mass_in_box(cloud: Cloud) -> None:
    rule = CentreOfMassInBox([-0.1, -0.1, 0.0], [0.1, 0.1, 0.3])
    ends = np.array([[0.5, 0.0, 0.1], [-0.5, 0.0, 0.1]])
    assert rule.violation(cloud(np.array([1.0, 1.0]), ends).vector) < 0.0
    assert rule.violation(cloud(np.array([2.0, 1.0]), ends).vector) > 0.0


def ellipsoid_points(count: int, radius: float, seed: int) -> Array:
    """Points of a scaled ellipsoid's surface."""
    directions = np.random.default_rng(seed).standard_normal((count, 3))
    directions *= radius / np.linalg.norm(directions, axis=1)[:, None]
    return np.asarray(CENTRE + directions * SEMI_AXES @ ROTATION.T)


def test_ellipsoid_tells_inside_from_outside(cloud: Cloud) -> None:
    rule = InEllipsoid(CENTRE, SEMI_AXES, ROTATION)
    for seed in range(50):
        masses = np.random.default_rng(seed).uniform(0.1, 1.0, 5)
        assert rule.violation(cloud(masses, ellipsoid_points(5, 0.99, seed)).vector) < 0.0
        assert rule.violation(cloud(masses, ellipsoid_points(5, 1.01, seed)).vector) > 0.0


def test_ellipsoid_in_the_wrong_frame_is_seen(cloud: Cloud) -> None:
    body = cloud(np.ones(5), ellipsoid_points(5, 0.99, 0))
    assert InEllipsoid(-CENTRE, SEMI_AXES, ROTATION).violation(body.vector) > 0.0


RULES: list[Constraint] = [
    PossibleBody(),
    MassBounds(1.0, 2.0),
    KnownMass(1.0, 0.1),
    CentreOfMassInBox([0, 0, 0], [1, 1, 1]),
    InEllipsoid(CENTRE, SEMI_AXES, ROTATION),
]


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: type(rule).__name__)
def test_every_constraint_is_a_value_with_one_line(rule: Constraint) -> None:
    assert rule.description
    assert "\n" not in rule.description
    assert len({rule, rule}) == 1
    with pytest.raises(AttributeError):
        rule.description = "another"  # type: ignore[misc]


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: MassBounds(3.0, 2.0), "low <= high"),
        (lambda: KnownMass(1.0, 0.0), "sigma must be positive"),
        (lambda: CentreOfMassInBox([0, 0, 1], [1, 1, 0]), "is empty"),
        (lambda: CentreOfMassInBox([0, 0], [1, 1]), "shape"),
        (lambda: InEllipsoid(CENTRE, [0.1, 0.0, 0.1]), "must be positive"),
        (lambda: InEllipsoid(CENTRE, SEMI_AXES, 2.0 * ROTATION), "orthonormal"),
    ],
)
def test_nonsense_is_refused(make: Callable[[], Constraint], text: str) -> None:
    with pytest.raises(InputError, match=text):
        make()
