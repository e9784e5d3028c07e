"""Each constraint: bodies that hold it pass, bodies that break it fail, and texts say what is demanded."""

from collections.abc import Callable

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.estimation import CentreOfMassInBox, InEllipsoid, KnownMass, MassBounds, PossibleBody
from dynident.estimation.possible.constraints import Constraint, InHull
from dynident.model import InertialParameters
from dynident.model.inertia import ten_parameters

Cloud = Callable[[Array, Array], InertialParameters]
ROTATION = np.linalg.qr(np.random.default_rng(5).standard_normal((3, 3)))[0]
CENTRE, SEMI_AXES = np.array([0.05, -0.1, 0.2]), np.array([0.1, 0.2, 0.3])
TETRAHEDRON = np.array([[0.0, 0.0, 0.0], [0.3, 0.0, 0.1], [0.0, 0.4, 0.0], [0.1, 0.1, 0.5]])
BOX = np.array([[x, y, z] for x in (-0.1, 0.2) for y in (-0.3, 0.1) for z in (0.0, 0.4)])
ROUNDING = 1e-12


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


@pytest.mark.parametrize("points", [TETRAHEDRON, BOX], ids=["tetrahedron", "box"])
def test_every_body_in_a_hull_passes(cloud: Cloud, points: Array) -> None:
    rule = InHull(points)
    for seed in range(100):
        draw = np.random.default_rng(seed)
        shares = draw.dirichlet(np.full(len(points), 0.3), size=4)
        assert rule.violation(cloud(draw.uniform(0.1, 1.0, 4), shares @ points).vector) <= ROUNDING


@pytest.mark.parametrize("points", [TETRAHEDRON, BOX], ids=["tetrahedron", "box"])
def test_mass_outside_a_hull_fails(cloud: Cloud, points: Array) -> None:
    """A point mass just beyond every vertex, and a body whose centre of mass is inside but which sticks out."""
    rule, middle = InHull(points), points.mean(axis=0)
    for vertex in points:
        assert rule.violation(cloud(np.ones(1), (middle + 1.01 * (vertex - middle))[None]).vector) > 0.0
    for direction in np.vstack([np.eye(3), ROTATION]):
        body = cloud(np.ones(2), np.array([middle + 0.6 * direction, middle - 0.6 * direction]))
        assert rule.violation(body.vector) > 0.0


def test_tetrahedron_is_exact() -> None:
    """J = V C V' with V its vertices: f_i' J f_j >= 0 says C >= 0, and C is then completely positive (4 x 4)."""
    rule = InHull(TETRAHEDRON)
    V = np.vstack([TETRAHEDRON.T, np.ones(4)])
    assert len(rule.facets) == 4
    heights = rule.facets @ V
    # Each facet holds three vertices.
    assert (np.sort(np.abs(heights), axis=1)[:, :3] < 1e-9).all()
    assert (heights.max(axis=1) > 0.01).all()


def test_hull_of_a_box_has_six_facets() -> None:
    assert len(InHull(BOX).facets) == 6


RULES: list[Constraint] = [
    PossibleBody(),
    MassBounds(1.0, 2.0),
    KnownMass(1.0, 0.1),
    CentreOfMassInBox([0, 0, 0], [1, 1, 1]),
    InEllipsoid(CENTRE, SEMI_AXES, ROTATION),
    InHull(BOX),
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
        (lambda: InHull(BOX * [1.0, 1.0, 0.0]), "no volume"),
        (lambda: InHull(BOX[:3]), "no volume"),
    ],
)
def test_nonsense_is_refused(make: Callable[[], Constraint], text: str) -> None:
    with pytest.raises(InputError, match=text):
        make()
