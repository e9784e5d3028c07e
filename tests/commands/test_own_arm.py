"""An arm of one's own goes through simulate, near, design and score; what its file lacks is assumed, and said."""

import re
import tomllib
from dataclasses import astuple, replace
from pathlib import Path

import numpy as np
import pytest
from dynident.common.errors import InputError
from dynident.model import INERTIAL, InertialParameters, load_robot, with_stand_in
from dynident.model.stand_in import cylinders
from dynident.tests.commands.runs import Run
from dynident.tests.frozen.inputs import EXAMPLES

SHEET = [
    "robot", "new", "--name", "own", "--joint", "z,0,0,0", "--joint=y,0.05,0,0.4", "--joint=y,0.05,0,0.8",
    "--joint=x,0.2,0,0.85", "--joint=y,0.45,0,0.85", "--joint=x,0.45,0,0.85", "--flange", "0.53,0,0.85,x,-z",
]  # fmt: skip
KNOWN = [
    "--limits=-170:170:220:900:300,-90:120:200:900:300,-100:80:220:900:150,"
    "-190:190:320:1500:50,-115:115:320:1500:40,-350:350:420:2000:30",
    "--rated-payload", "5",
]  # fmt: skip
URDF = EXAMPLES / "robots/six_axis.urdf"


def bodiless(text: str, *links: str) -> str:
    """A URDF without the bodies of some links, or of all."""
    for link in links or ("link[1-6]",):
        text = re.sub(rf'(<link name="{link}">)\s*<inertial>.*?</inertial>', r"\1", text, flags=re.DOTALL)
    return text


ARMS: dict[str, tuple[list[str] | str, list[str], set[str]]] = {
    "all known but bodies": ([*KNOWN, "--mass", "30"], [], {"parameters"}),
    "mass alone": (["--mass", "30"], [], {"position", "speed", "acceleration", "torque", "parameters"}),
    "mass given to the command": (KNOWN, ["--arm-mass", "30"], {"parameters"}),
    "a URDF": (bodiless(URDF.read_text(), "none"), [], {"acceleration", "torque", "parameters"}),
    "a URDF without some bodies": (
        bodiless(URDF.read_text(), "link2", "link6"), [], {"acceleration", "torque", "parameters"},
    ),
    "a URDF without bodies": (
        bodiless(URDF.read_text()), ["--arm-mass", "60"], {"acceleration", "torque", "parameters"},
    ),
}  # fmt: skip
COSTLY = ("mass alone", "mass given to the command", "a URDF", "a URDF without some bodies")


def described(run: Run, folder: Path, arm: list[str] | str) -> str:
    """The arm's file: written by ``robot new``, or a URDF."""
    path = folder / ("own.urdf" if isinstance(arm, str) else "own.toml")
    if isinstance(arm, str):
        path.write_text(arm, encoding="utf-8")
    else:
        assert run(*SHEET, *arm, "--out", str(path))[0] == 0
    return str(path)


@pytest.mark.parametrize("name", ARMS)
def test_what_is_known_stays_and_the_rest_can_exist(run: Run, tmp_path: Path, name: str) -> None:
    """Every limit is finite, every link a body; a number of the file is never replaced."""
    arm, more, lacking = ARMS[name]
    known = load_robot(described(run, tmp_path, arm))
    robot = with_stand_in(replace(known, mass=float(more[1])) if more else known)
    assert set(robot.assumed()) == lacking
    assert known.parameters.items() <= robot.parameters.items()
    for link, (joint, before) in enumerate(zip(robot.joints, known.joints, strict=True), start=1):
        numbers, stated = (np.hstack(astuple(limits)) for limits in (joint.limits, before.limits))
        assert np.isfinite(numbers).all()
        np.testing.assert_array_equal(numbers[np.isfinite(stated)], stated[np.isfinite(stated)])
        body = InertialParameters(np.array([robot.parameters[f"{kind}{link}"] for kind in INERTIAL]))
        assert body.min_pseudo_inertia_eigenvalue > 0.0
        assert robot.parameters[f"IA{link}"] > 0.0
    if "acceleration" in lacking:
        speeds, accelerations = np.array([(j.limits.speed, j.limits.acceleration) for j in robot.joints]).T
        np.testing.assert_allclose(accelerations, 10.0 * speeds)


def test_links_without_bodies_are_as_dense_as_the_others(run: Run, tmp_path: Path) -> None:
    """Mass over length and the cross-section of one radius is one number over the cylinders, and their sum."""
    arm = ARMS["a URDF without some bodies"][0]
    known = load_robot(described(run, tmp_path, arm))
    robot, shares = with_stand_in(known), [body.mass for body in cylinders(known, 1.0)]
    masses = [robot.parameters[f"M{link}"] for link in range(1, 7)]
    assert masses[1] / shares[1] == pytest.approx(masses[5] / shares[5])
    others = (0, 2, 3, 4)
    assert sum(masses[k] for k in others) == pytest.approx(10.0 + 5.0 + 4.0 + 2.0)
    assert masses[1] / shares[1] == pytest.approx(21.0 / sum(shares[k] for k in others))


def test_a_part_of_a_body_is_none() -> None:
    robot = load_robot("ur10e")
    with pytest.raises(InputError, match="lacks XX1"):
        with_stand_in(replace(robot, parameters={"M1": 3.0}))


def test_a_huge_effort_is_unknown(tmp_path: Path) -> None:
    """Where a URDF writes a torque that no joint has, a limit is assumed in its place, and said."""
    assert 'effort="1000000.0"' in URDF.read_text()
    assert all(joint.limits.torque == np.inf for joint in load_robot(URDF).joints)
    path = tmp_path / "a.urdf"
    path.write_text(URDF.read_text().replace('effort="1000000.0"', 'effort="90"'))
    assert all(joint.limits.torque == 90.0 for joint in load_robot(path).joints)


@pytest.mark.long
@pytest.mark.usefixtures("hasty")
@pytest.mark.parametrize("name", COSTLY)
def test_own_arm_is_rehearsed(run: Run, tmp_path: Path, name: str) -> None:
    """The motion that was designed runs in the simulation, and each answer names what was assumed."""
    arm, more, lacking = ARMS[name]
    robot = ["--robot", described(run, tmp_path, arm), *more]
    motion, logs = str(tmp_path / "wide.csv"), tmp_path / "logs"
    lines = {
        "near": [
            "--pose=0,-45,60,0,45,0",
            "--joints",
            "2,3,5,6",
            "--range",
            "20",
            "--duration",
            "4",
            "--starts",
            "1",
        ],
        "design": ["--via-points", "3", "--starts", "1", "--columns", "payload", "--samples", motion],
        "score": [motion, "--columns", "payload"],
        "simulate": ["--trajectory", motion, "--rate", "50", "--out", str(logs)],
    }
    for command, words in lines.items():
        details = [] if command == "simulate" else ["--details"]
        status, text, error = run(command, *words, *robot, *details)
        assert status == 0, f"{command}: {error}"
        plain = " ".join(text.split())
        for part in lacking:
            assumption = {"parameters": "links and drives of the stand-in"}.get(part, f"{part} limits")
            assert re.search(f"Assumed, not published: [^.]*{assumption}", plain), (command, part)
    truth = tomllib.loads((logs / "truth.toml").read_text())
    assert set(truth["assumed"]) == lacking


@pytest.mark.parametrize("command", ["simulate", "near"])
def test_without_a_mass_one_line_names_the_option(run: Run, tmp_path: Path, command: str) -> None:
    words = {"simulate": ["--out", str(tmp_path)], "near": ["--pose=0,-45,60,0,45,0", "--joints", "2,3,5,6"]}[
        command
    ]
    arms: tuple[list[str] | str, ...] = ([re.sub(r":\d+:\d+(?=,|$)", "", KNOWN[0])], bodiless(URDF.read_text()))
    for arm in arms:
        status, _, error = run(command, "--robot", described(run, tmp_path, arm), *words)
        assert (status, error.count("\n")) == (2, 1)
        assert "--arm-mass KG" in error
