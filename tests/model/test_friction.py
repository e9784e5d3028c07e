"""Terms of friction: every law on every robot, through the regressor, the dynamics, files and code."""

from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from dynident import model
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.model.base import random_states
from dynident.model.drives import DriveState, parameter_kind, smooth_sign
from dynident.model.files.robot_file import robot_toml
from dynident.model.friction import LAWS, PAPER, Friction, friction_terms, is_friction, term_names, terms_of
from dynident.model.regressors import own_regressor, regressor_at

STATES = 12


def own_law() -> ca.Function:
    speed, position, load = (ca.SX.sym(name) for name in ("speed", "position", "load"))
    return ca.Function("law", [speed, position, load], [ca.sin(position) * ca.sign(speed) + 0.1 * load])


EVERY = (*friction_terms(["FS", "FV", "FL", "FR", "FB@0.4"]), Friction.of("FX", "N·m", own_law()))


@pytest.fixture
def rubbing(robot: model.Robot) -> model.Robot:
    """A robot with all terms at all joints; without offsets asymmetric Coulomb friction too."""
    return robot.with_friction(EVERY if robot.drives.offsets else (*EVERY, Friction("FA")))


def drawn(robot: model.Robot, seed: int = 5) -> Array:
    """Standard parameters of possible size, friction positive."""
    draw = np.random.default_rng(seed)
    values = {name: float(draw.uniform(0.1, 1.0)) for name in model.standard_columns(robot)}
    for name in values:
        if parameter_kind(name) in ("XY", "XZ", "YZ", "MX", "MY", "MZ"):
            values[name] *= 0.1
        if parameter_kind(name) in ("XX", "YY", "ZZ", "M", "IA"):
            values[name] += 1.0
        if parameter_kind(name) == "FL":
            values[name] *= 0.1
    return np.array([values[name] for name in model.standard_columns(robot)])


def carried(robot: model.Robot, chi: Array, states: tuple[Array, Array, Array]) -> Array:
    """Torque of links and spring, N x n."""
    rigid = np.where(
        [is_friction(name) or name.startswith("IA") for name in model.standard_columns(robot)], 0.0, chi
    )
    return np.array(model.inverse_dynamics(robot)(*(x.T for x in states), rigid)).T


def test_regressor_times_parameters_is_the_torque(rubbing: model.Robot) -> None:
    """By CasADi and by NumPy: the load that the columns are given is that of the same parameters."""
    chi, states = drawn(rubbing), random_states(rubbing, STATES, seed=2)
    load, phi = carried(rubbing, chi, states), model.standard_regressor(rubbing)
    assert phi.name_in() == list(DriveState._fields)
    torque = np.array(model.inverse_dynamics(rubbing)(*(x.T for x in states), chi)).T
    columns = np.array(phi.map(STATES)(*(x.T for x in (*states, load))))
    by_casadi = np.array([part @ chi for part in np.split(columns, STATES, axis=1)])
    if rubbing.spring is not None:
        joint = rubbing.spring.joint - 1
        by_casadi[:, joint] -= rubbing.spring.torque(states[0][:, joint])
        assert not rubbing.spring.column
    np.testing.assert_allclose(by_casadi, torque, rtol=1e-10, atol=1e-10 * np.abs(torque).max())
    by_numpy = regressor_at(rubbing, model.standard_columns(rubbing), *states, load)
    np.testing.assert_allclose(
        by_numpy, np.array(np.split(columns, STATES, axis=1)).transpose(1, 2, 0), rtol=1e-9, atol=1e-9
    )


@pytest.mark.parametrize("kind", [kind for kind in LAWS if kind != "FA"])
def test_friction_takes_power(robot: model.Robot, kind: str) -> None:
    """On coupled drives too, whose gears turn with other speeds than the joints."""
    terms = friction_terms([*({"FS", "FV"} if robot.coupling else ()), "FB@0.4" if kind == "FB" else kind])
    rubbing, states = robot.with_friction(terms), random_states(robot, STATES, seed=3)
    chi = drawn(rubbing)
    without = np.where([parameter_kind(name) == kind for name in model.standard_columns(rubbing)], 0.0, chi)
    torque, less = (np.array(model.inverse_dynamics(rubbing)(*(x.T for x in states), v)).T for v in (chi, without))
    power = np.sum(states[1] * (torque - less), axis=1)
    assert (power > 0.0).all()


def test_load_friction_of_a_lifted_pendulum() -> None:
    """1 m, 2 kg, level: it lifts with the torque of gravity and a tenth more, and lowers with a tenth less."""
    robot = model.Robot(
        "arm", (model.Joint(alpha=np.pi / 2),), drives=model.Drives(friction=friction_terms(["FL"]))
    )
    chi = np.array([{"MX1": 2.0, "FL1": 0.1}.get(name, 0.0) for name in model.standard_columns(robot)])
    up, down, rest = (float(model.inverse_dynamics(robot)(0.0, speed, 0.0, chi)[0]) for speed in (1e-3, -1e-3, 0.0))
    assert abs(rest) == pytest.approx(2.0 * 9.81, rel=1e-6)
    assert up - rest == pytest.approx(0.1 * abs(rest), rel=1e-4)
    assert rest - down == pytest.approx(0.1 * abs(rest), rel=1e-4)


def test_forward_dynamics_is_the_inverse(robot: model.Robot) -> None:
    """Load friction depends on the acceleration itself."""
    rubbing = robot.with_friction((*PAPER, Friction("FL")) if robot.drives.friction else (Friction("FL"),))
    chi, (q, qd, qdd) = drawn(rubbing), random_states(rubbing, STATES, seed=4)
    inverse, forward = model.inverse_dynamics(rubbing), model.forward_dynamics(rubbing)
    torque = np.array(inverse(q.T, qd.T, qdd.T, chi))
    again = np.array(forward(q.T, qd.T, torque, chi))
    np.testing.assert_allclose(again, qdd.T, atol=1e-5 * np.abs(qdd).max())


def test_terms_are_base_parameters_of_their_own(rubbing: model.Robot) -> None:
    """No term is grouped into others, and none changes how links are: by rank and by Khalil's rules."""
    by_rank, by_rules = model.base_parameters(rubbing), model.closed_form_base_parameters(rubbing)
    plain = model.base_parameters(rubbing.with_friction(PAPER if rubbing.coupling else ()))
    assert by_rank.columns == by_rules.columns
    assert [name for name in by_rank.columns if not is_friction(name)] == [
        name for name in plain.columns if not is_friction(name)
    ]
    terms = [name for name in model.standard_columns(rubbing) if name.startswith("F")]
    vertical = {name for name in set(terms) - set(by_rank.columns) if name.startswith("FA")}
    assert set(terms) - vertical <= set(by_rank.columns)
    assert all(not rubbing.joints[int(name[2:]) - 1].revolute for name in vertical)  # the weight of a slide


def test_files_hold_every_term(rubbing: model.Robot, tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    path.write_text(robot_toml(rubbing), encoding="utf-8")
    again = model.load_robot(str(path))
    assert again.drives.friction == rubbing.drives.friction
    assert again.fingerprint == rubbing.fingerprint


def test_names_tell_the_terms(robot: model.Robot) -> None:
    some = friction_terms(["FS", "FV", "FL1", f"FL{robot.n}", "FR"])
    assert list(term_names(some)) == ["FS", "FV", "FL1", f"FL{robot.n}", "FR"]
    names = model.standard_columns(robot.with_friction(some))
    assert terms_of(names, robot.drives.friction, robot.n) == some
    assert robot.of_parameters(names) == robot.with_friction(some)


def test_names_keep_each_stribeck_speed() -> None:
    robot = model.load_robot("ur10e").with_friction(friction_terms(["FS", "FV", "FB2@0.1", "FB3@0.12345678"]))
    assert robot.of_parameters(model.standard_columns(robot)) == robot
    assert friction_terms(term_names(robot.drives.friction)) == robot.drives.friction


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (["FS", "FZ"], "friction 'FZ': give terms such as"),
        (["FB"], "needs a speed"),
        (["FS@3"], "no other term has one"),
        (["IA"], "friction 'IA'"),
        (["FL0"], "friction 'FL0'"),
        (["FB@1.2.3"], "friction 'FB@1.2.3'"),
    ],
)
def test_wrong_terms_are_refused(names: list[str], message: str) -> None:
    with pytest.raises(InputError, match=message):
        friction_terms(names)


def test_a_law_of_other_inputs_is_refused() -> None:
    x = ca.SX.sym("x")
    with pytest.raises(InputError, match="must take speed, position and load"):
        Friction.of("FX", "N·m", ca.Function("law", [x], [x]))
    with pytest.raises(InputError, match="must be F and more capitals"):
        Friction.of("X", "N·m", own_law())


def test_a_law_that_is_no_number_somewhere_is_refused() -> None:
    speed, position, load = (ca.SX.sym(name) for name in ("speed", "position", "load"))
    term = Friction.of("FN", "N·m", ca.Function("law", [speed, position, load], [ca.log(speed)]), 2)
    with pytest.raises(InputError, match="FN2: the law is no number"):
        model.base_parameters(model.load_robot("ur10e").with_friction((*PAPER, term)))


def test_robots_refuse_what_joints_cannot_have() -> None:
    robot = model.load_robot("ur10e")
    for terms, message in (
        (friction_terms(["FS", "FL7"]), "name joint 7, the robot has joints 1 to 6"),
        ((*PAPER, Friction("FS", 2)), "joint 2 has a term of friction twice"),
        (friction_terms(["FS", "FA"]), "FA and the offsets are one column"),
    ):
        with pytest.raises(InputError, match=message):
            robot.with_offsets(True).with_friction(terms)
    with pytest.raises(InputError, match="FS and FV at all joints"):
        model.load_robot("rx90").with_friction(friction_terms(["FS", "FV2"]))


def test_smoothed_terms_near_the_exact_ones(rubbing: model.Robot) -> None:
    """Under the load of the robot's own parameters, at speeds far above the width."""
    columns = model.standard_columns(rubbing)
    robot = replace(rubbing, parameters=dict(zip(columns, drawn(rubbing).tolist(), strict=True)))
    q, qd, qdd = random_states(robot, STATES, seed=6)
    qd = np.abs(qd) + 1.0  # of coupled drives the sum too
    kinds = [k for k, name in enumerate(columns) if not name.startswith("FX")]  # its own sign is not smoothed
    exact, smooth = (
        ca.Function("regressor", [*state[:3]], [phi])
        for state, phi in (own_regressor(robot, columns), own_regressor(robot, columns, smooth_sign(1e-3)))
    )
    for k in range(STATES):
        W = np.array(exact(q[k], qd[k], qdd[k]))[:, kinds]
        np.testing.assert_allclose(np.array(smooth(q[k], qd[k], qdd[k]))[:, kinds], W, atol=1e-9)
