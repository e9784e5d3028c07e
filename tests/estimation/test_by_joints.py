"""The payload as single joints see it."""

from dataclasses import replace

import numpy as np
import pytest
from dynident.benchmarks import invented
from dynident.common.errors import InputError
from dynident.estimation import PAYLOAD, LongMotion, Settings, answer_payload, payload_estimate, payload_problem
from dynident.estimation.equations.equations import Equations
from dynident.estimation.fit.least_squares import weighted
from dynident.estimation.payload.by_joints import ByJoints, joint_groups, payload_by_joints
from dynident.tests.estimation import mistakes


def problem_of(name: str, factor: float = 1.0, joint: int = 1, blocks: bool = True) -> LongMotion:
    """The gallery's good recordings, one joint's torque scaled."""
    _, bare, loaded, _ = mistakes.good(name)
    change = mistakes.scaled(joint, factor)
    return payload_problem(invented.robot(name), [change(loaded)], [change(bare)], settings=Settings(robust=blocks))


def seen(problem: LongMotion) -> ByJoints:
    return payload_by_joints(problem, payload_estimate(problem, 1).estimate.weights)


def without_blocks(problem: LongMotion) -> LongMotion:
    return replace(problem, loaded=problem.loaded.whole, difference=None)


@pytest.fixture(scope="module")
def problems() -> dict[str, LongMotion]:
    return {name: problem_of(name) for name in invented.NAMES}


@pytest.mark.long
@pytest.mark.parametrize("name", ["rx90", "tx40"])
def test_the_joints_of_a_spherical_wrist_do_not_see_the_mass(problems: dict[str, LongMotion], name: str) -> None:
    """Rank 9 of 10 whatever the motion: no minimum-norm number with a small sigma."""
    masses = {group.joints: group for group in seen(problems[name]).masses}
    for joints in ((4,), (5,), (6,), (4, 5, 6)):
        assert masses[joints].mass is None
        assert masses[joints].interval95 is None
        assert np.isnan(masses[joints].sigma)
    truth = mistakes.good(name)[3].mass
    for joints in ((1,), (2,), (3,), (1, 2, 3)):
        low, high = masses[joints].interval95 or (np.nan, np.nan)
        assert low - 0.02 * truth < truth < high + 0.02 * truth


@pytest.mark.long
def test_on_the_ur10e_joints_1_to_4_see_the_mass(problems: dict[str, LongMotion]) -> None:
    by_joints = seen(problems["ur10e"])
    assert [group.mass is not None for group in by_joints.masses] == [True] * 4 + [False] * 2 + [True] * 2
    truth = mistakes.good("ur10e")[3].mass
    assert all(abs(group.mass / truth - 1.0) < 0.05 for group in by_joints.masses if group.mass is not None)


def test_a_group_sees_what_method_3_sees_in_its_rows(problems: dict[str, LongMotion]) -> None:
    """A group's mass is that of method 3 with the other joints' weights at zero."""
    problem = problems["rx90"]
    assert problem.difference is not None
    own = payload_estimate(problem, 3).estimate
    weights = np.array([own.weights[0], own.weights[1], own.weights[2], 0.0, 0.0, 0.0])
    arm = weighted(problem.difference.select(PAYLOAD), weights)
    group = payload_by_joints(problem, own.weights).masses[6]
    assert group.joints == (1, 2, 3)
    assert group.mass == pytest.approx(arm["M_L"], rel=1e-9)


@pytest.mark.parametrize(("name", "joint", "factor"), [("rx90", 2, 2.0), ("rx90", 5, 0.5), ("tx40", 4, 1.5)])
def test_a_wrong_gain_shows_as_that_joints_share(name: str, joint: int, factor: float) -> None:
    shares = {entry.joint: entry for entry in seen(problem_of(name, factor, joint)).shares}
    own = shares[joint]
    assert own.share is not None
    assert abs(own.share - factor) < max(5.0 * own.sigma, 0.1)
    assert all(entry.share is not None and entry.sigma > 0.0 for entry in shares.values())


def test_a_known_robot_and_other_trajectories_give_the_same_masses(problems: dict[str, LongMotion]) -> None:
    problem = problems["rx90"]
    assert problem.unloaded is not None
    known = replace(without_blocks(problem), unloaded=None, known=weighted(problem.unloaded), inflation=())
    apart = without_blocks(problem)
    truth = mistakes.good("rx90")[3].mass
    for group, other_group in zip(seen(known).masses, seen(apart).masses, strict=True):
        assert (group.mass is None) == (other_group.mass is None)
        if group.mass is not None and other_group.mass is not None:
            assert group.mass == pytest.approx(other_group.mass, rel=1e-9)
            assert abs(group.mass - truth) < 4.0 * group.sigma


def test_groups_of_short_robots_are_single_joints() -> None:
    assert joint_groups(3) == ((1,), (2,), (3,))
    assert joint_groups(6)[-2:] == ((1, 2, 3), (4, 5, 6))


def test_rows_that_hide_a_parameter_give_an_error_and_no_minimum_norm_answer() -> None:
    """Only the wrist's rows left: the mass is in no equation."""
    problem = problem_of("rx90", blocks=False)
    keep = (3, 4, 5)

    def wrist(part: Equations | None) -> Equations:
        assert part is not None
        factors = tuple(f if j in keep else 0.0 * f[:0] for j, f in enumerate(part.factors))
        rows = tuple(r if j in keep else 0 for j, r in enumerate(part.rows))
        return replace(part, factors=factors, rows=rows, effective_rows=tuple(map(float, rows)))

    blind = replace(problem, loaded=wrist(problem.loaded), difference=wrist(problem.difference))
    with pytest.raises(InputError, match=r"undetermined, in .*M_L"):
        answer_payload(blind, (1,))
    with pytest.raises(InputError, match=r"undetermined, in .*M_L"):
        answer_payload(blind, (3,))
