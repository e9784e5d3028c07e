"""Every controller's format is parsed back to the same body; what it would refuse is refused before."""

import json
import re
import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple, get_args

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from dynident.apps.commands.export import Name
from dynident.apps.export.controllers import FORMATS
from dynident.apps.export.load import ControllerLoad, load_of
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.common.schema import convert
from dynident.estimation import PayloadResult
from dynident.model import InertialParameters, Pose
from dynident.model.inertia import ten_parameters
from dynident.tests.commands.typed import Ended, typed
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation


class Body(NamedTuple):
    """Mass [kg], centre of mass [m], 3 x 3 inertia about it [kg m^2] in the axes of the frame."""

    mass: float
    com: Array
    inertia: Array


def _numbers(text: str) -> list[float]:
    return [float(word) for word in re.findall(r"(?<![\w.])-?\d+\.?\d*(?:e[-+]?\d+)?(?![\w.])", text)]


def _code(text: str, comment: str) -> str:
    return "\n".join(line for line in text.splitlines() if not line.startswith(comment))


def _turned(moments: list[float], axes: Rotation) -> Array:
    R = axes.as_matrix()
    assert np.linalg.det(R) == pytest.approx(1.0)
    return np.asarray(R @ np.diag(moments) @ R.T)


def abb(text: str) -> Body:
    code = _code(text, "!")
    assert re.fullmatch(r"PERS loaddata \w+ := \[[^\[]*, \[[^\[]*\], \[[^\[]*\], [^\[]*\];", code)
    mass, x, y, z, q1, q2, q3, q4, *moments = _numbers(code)
    assert np.linalg.norm([q1, q2, q3, q4]) == pytest.approx(1.0, abs=1e-8)
    return Body(mass, np.array([x, y, z]) / 1000, _turned(moments, Rotation.from_quat([q2, q3, q4, q1])))


def kuka(text: str) -> Body:
    line = _code(text, ";")
    real = r"(-?\d+\.\d+)"
    pattern = (
        rf"LOAD_DATA\[1\]=\{{M {real},CM \{{X {real},Y {real},Z {real},A {real},B {real},C {real}\}},"
        rf"J \{{X {real},Y {real},Z {real}\}}\}}"
    )
    match = re.fullmatch(pattern, line)
    assert match, line
    mass, x, y, z, a, b, c, *moments = (float(group) for group in match.groups())
    axes = Rotation.from_euler("ZYX", [a, b, c], degrees=True)  # capital letters: each about the new axis
    return Body(mass, np.array([x, y, z]) / 1000, _turned(moments, axes))


def ur(text: str) -> Body:
    code = _code(text, "#")
    assert code.startswith("set_target_payload(")
    mass, x, y, z, *rest = _numbers(code)
    xx, yy, zz, xy, xz, yz = rest or [0.0] * 6
    return Body(mass, np.array([x, y, z]), np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))


def ros2(text: str) -> Body:
    code = _code(text, "#")
    call = re.fullmatch(r"ros2 service call /\S+/set_payload ur_msgs/srv/SetPayload \"\{(.*)\}\"", code)
    assert call
    numbers = {name: float(value) for name, value in re.findall(r"(\w+): (-?\d+\.\d+)", call[1])}
    entries = [[numbers.get(f"i{min(a, b)}{max(a, b)}", 0.0) for b in "xyz"] for a in "xyz"]
    return Body(numbers["mass"], np.array([numbers[axis] for axis in "xyz"]), np.array(entries))


def franka(text: str) -> Body:
    code = _code(text, "//")
    assert code.startswith("robot.setLoad(")
    mass, x, y, z, *inertia = _numbers(code)
    columns = [inertia[0:3], inertia[3:6], inertia[6:9]]
    return Body(mass, np.array([x, y, z]), np.column_stack(columns))


def _table(text: str, scales: list[float]) -> list[float]:
    lines = _code(text, "#").splitlines()
    return [float(line.split()[-1]) * scale for line, scale in zip(lines, scales, strict=True)]


def fanuc(text: str) -> Body:
    """1 kgf is 9.80665 N: 1 kgf cm s^2 = 9.80665 kg m/s^2 * 0.01 m * s^2."""
    assert [line.split("[")[0].split()[-1] for line in _code(text, "#").splitlines()] == ["PAYLOAD", *"XYZXYZ"]
    mass, x, y, z, *moments = _table(text, [1.0] + 3 * [0.01] + 3 * [0.0980665])
    return Body(mass, np.array([x, y, z]), np.diag(moments))


def yaskawa(text: str) -> Body:
    assert [line.split()[0] for line in _code(text, "#").splitlines()] == ["W", "Xg", "Yg", "Zg", "Ix", "Iy", "Iz"]
    mass, x, y, z, *moments = _table(text, [1.0] + 3 * [1e-3] + 3 * [1.0])
    return Body(mass, np.array([x, y, z]), np.diag(moments))


def staubli(text: str) -> Body:
    lines = _code(text, "#").splitlines()
    values = {line.split("[")[0].strip(): float(line.split()[-1]) for line in lines}
    J = np.array([[values.get(f"I{min(a, b)}{max(a, b)}", 0.0) for b in "xyz"] for a in "xyz"])
    return Body(values["mass"], np.array([values[f"com {axis}"] for axis in "xyz"]), J)


def urdf(text: str) -> Body:
    inertia = pin.buildModelFromXML(text, pin.JointModelFreeFlyer()).inertias[1]
    return Body(inertia.mass, np.array(inertia.lever), np.array(inertia.inertia))


def sdf(text: str) -> Body:
    inertial = ET.fromstring(text).find("./model/link/inertial")
    assert inertial is not None
    x, y, z, *turn = _numbers(inertial.findtext("pose", ""))
    assert turn == [0.0] * 3
    entries = {name: float(inertial.findtext(f"inertia/{name}", "nan")) for name in
               ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")}  # fmt: skip
    J = np.array([[entries[f"i{min(a, b)}{max(a, b)}"] for b in "xyz"] for a in "xyz"])
    return Body(float(inertial.findtext("mass", "")), np.array([x, y, z]), J)


def mjcf(text: str) -> Body:
    model = mujoco.MjModel.from_xml_string(text)
    body = model.body("payload")
    w, x, y, z = body.iquat
    return Body(float(body.mass[0]), np.array(body.ipos), _turned(body.inertia, Rotation.from_quat([x, y, z, w])))


def usd(text: str) -> Body:
    assert text.startswith("#usda 1.0\n")

    def values(name: str, default: list[float]) -> list[float]:
        match = re.search(rf"^\s*(?:\w+ )?{name} = (.*)$", text, flags=re.MULTILINE)
        return _numbers(match[1]) if match else default

    (unit,), (mass,) = values("metersPerUnit", []), values("physics:mass", [])
    assert values("kilogramsPerUnit", []) == [1.0]
    w, x, y, z = values("physics:principalAxes", [1.0, 0.0, 0.0, 0.0])
    moments = np.array(values("physics:diagonalInertia", [0.0] * 3)) * unit**2
    com = np.array(values("physics:centerOfMass", [])) * unit
    return Body(mass, com, _turned(list(moments), Rotation.from_quat([x, y, z, w])))


PARSERS: dict[str, Callable[[str], Body]] = {
    "abb": abb, "kuka": kuka, "ur": ur, "ros2": ros2, "franka": franka, "fanuc": fanuc, "yaskawa": yaskawa,
    "staubli": staubli, "urdf": urdf, "sdf": sdf, "mjcf": mjcf, "usd": usd,
}  # fmt: skip
MOMENTS_ONLY = {"fanuc", "yaskawa"}
"""Formats without products of inertia."""

SOURCE = "p.json, method 4 (constrained)"


def controller_load(body: InertialParameters, **more: object) -> ControllerLoad:
    return replace(ControllerLoad(body, "tool0: flange", SOURCE, "use"), **more)  # type: ignore[arg-type]


def heads(name: str, load: ControllerLoad) -> list[str]:
    form = FORMATS[name]
    return list(form.head(form, form.ready(load)))


def elements(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_subnormal=False)


@st.composite
def bodies(draw: st.DrawFn) -> InertialParameters:
    """Sums of two to six point masses: thin, flat and full bodies."""
    count = draw(st.integers(2, 6))
    masses = draw(arrays(np.float64, count, elements=elements(0.1, 10.0)))
    points = draw(arrays(np.float64, (count, 3), elements=elements(-0.5, 0.5)))
    com = masses @ points / masses.sum()
    arms = points - com
    inertia = sum(m * (r @ r * np.eye(3) - np.outer(r, r)) for m, r in zip(masses, arms, strict=True))
    assume(np.trace(inertia) > 1e-6)
    return InertialParameters.from_com(float(masses.sum()), com, inertia)


@st.composite
def frames(draw: st.DrawFn) -> tuple[Array, Array]:
    turn = draw(arrays(np.float64, 3, elements=elements(-3.0, 3.0)))
    return Rotation.from_rotvec(turn).as_matrix(), draw(arrays(np.float64, 3, elements=elements(-1.0, 1.0)))


def check(name: str, load: ControllerLoad, body: InertialParameters) -> None:
    """The parsed body is the given one: to ten digits, and 1e-6 of the trace for bodies at the edge."""
    parsed = PARSERS[name](FORMATS[name].text(load))
    assert parsed.mass == pytest.approx(body.mass, rel=1e-9)
    np.testing.assert_allclose(parsed.com, body.com, atol=1e-9 * (1.0 + np.abs(body.com).max()))
    given_inertia = np.diag(np.diag(body.inertia_com)) if name in MOMENTS_ONLY else body.inertia_com
    trace = float(np.trace(body.inertia_com))
    widened = load.rounded().widened
    np.testing.assert_allclose(parsed.inertia, given_inertia + widened * np.eye(3), atol=1e-8 * trace + 1e-14)
    assert widened <= 1.1e-6 * trace


def test_there_is_a_parser_for_every_format_and_help_names_them_all() -> None:
    assert list(get_args(Name)) == list(FORMATS)
    assert set(PARSERS) == set(FORMATS)


@pytest.mark.parametrize("name", FORMATS)
@settings(max_examples=40)
@given(body=bodies(), frame=frames())
def test_parsed_back(name: str, body: InertialParameters, frame: tuple[Array, Array]) -> None:
    R, p = frame
    load = controller_load(body.moved(R, p)).seen_from(Pose.of(R, p), "flange")
    check(name, load, body)


SPECIAL = {
    "unlike entries": InertialParameters.from_com(
        2.5, [0.03, -0.02, 0.12], [[0.031, 0.002, -0.004], [0.002, 0.027, 0.003], [-0.004, 0.003, 0.019]]
    ),
    "ball": InertialParameters.from_com(2.0, [0.0, 0.0, 0.1], 0.002 * np.eye(3)),
    "two equal moments, oblique": InertialParameters.from_com(
        3.0, [0.1, 0.0, 0.1], 0.02 * np.eye(3) + 0.01 * np.outer([0.6, 0.0, 0.8], [0.6, 0.0, 0.8])
    ),
    "nearly a ball": InertialParameters.from_com(2.0, [0.0, 0.0, 0.1], 0.002 * np.eye(3) + 1e-17 * np.ones((3, 3))),
    "disc": InertialParameters.from_com(3.0, [0.0, 0.0, 0.05], np.diag([0.01, 0.01, 0.02])),
    "rod": InertialParameters.from_com(1.0, [0.2, 0.0, 0.0], np.diag([0.0, 0.01, 0.01])),
    "long way round": InertialParameters.from_com(
        1.0, [0.0, 0.0, 0.0], Rotation.from_euler("ZYX", [170, 90, 35], degrees=True).as_matrix()
        @ np.diag([0.01, 0.02, 0.025])
        @ Rotation.from_euler("ZYX", [170, 90, 35], degrees=True).as_matrix().T,
    ),
    "tiny": InertialParameters.from_com(1e-3, [1e-4, 0.0, 2e-4], 1e-9 * np.diag([1.0, 1.2, 1.4])),
    "large": InertialParameters.from_com(2300.0, [0.1, -0.4, 1.2], np.diag([120.0, 90.0, 110.0])),
}  # fmt: skip


@pytest.mark.parametrize("name", FORMATS)
@pytest.mark.parametrize("special", SPECIAL)
def test_special_bodies(name: str, special: str) -> None:
    check(name, controller_load(SPECIAL[special]), SPECIAL[special])


@pytest.mark.parametrize("name", FORMATS)
def test_mass_and_com_only(name: str) -> None:
    """No number of the inertia appears, and the file says what it does instead."""
    body = SPECIAL["unlike entries"]
    load = controller_load(body, point_mass=True, verdict="mass_and_com_only", reasons=("method 1 is vague",))
    text = FORMATS[name].text(load)
    parsed = PARSERS[name](text)
    assert parsed.mass == pytest.approx(2.5)
    np.testing.assert_allclose(parsed.com, body.com, atol=1e-9)
    np.testing.assert_allclose(parsed.inertia, np.zeros((3, 3)), atol=1e-16)
    head = "\n".join(heads(name, load))
    assert "Mass and centre of mass only: " in head
    assert "method 1 is vague" in head


@pytest.mark.parametrize("name", FORMATS)
def test_the_file_says_what_its_numbers_mean(name: str) -> None:
    form, load = FORMATS[name], controller_load(SPECIAL["unlike entries"])
    head = heads(name, load)
    for word in ("dynident", SOURCE, "Verdict: use", "Frame: tool0", "Reference: ", "Order: ", "Units: ", "kg"):
        assert word in "\n".join(head), word
    assert all(line.strip() in form.text(load) for line in head)
    assert form.text(load).endswith("\n")
    assert form.text(load).isascii()
    assert not re.search(r"\bnan\b|\binf\b|-0\.0\b", form.text(load))


@pytest.mark.parametrize("name", FORMATS)
@settings(max_examples=25)
@given(body=bodies(), exponents=st.tuples(*3 * [st.floats(-4.0, -1.0)]))
def test_numbers_are_rounded_to_what_their_intervals_support(
    name: str, body: InertialParameters, exponents: tuple[float, float, float]
) -> None:
    """Within a tenth of the half-width (an inertia that must stay possible within five), and no body impossible."""
    trace = float(np.trace(body.inertia_com))
    halves = (10.0 ** exponents[0], 10.0 ** (exponents[1] - 1.0), trace * 10.0 ** (exponents[2] - 1.0))
    assume(halves[2] > 1e-7)
    load = controller_load(body, half_widths=halves)
    assume(load.rounded().mass > 0.0)
    parsed = PARSERS[name](FORMATS[name].text(load))
    assert parsed.mass == pytest.approx(body.mass, abs=0.1 * halves[0])
    np.testing.assert_allclose(parsed.com, body.com, atol=0.1 * halves[1])
    theirs = np.diag(np.diag(body.inertia_com)) if name in MOMENTS_ONLY else body.inertia_com
    np.testing.assert_allclose(parsed.inertia, theirs, atol=0.5 * halves[2])
    assert load.rounded().body.physically_consistent


def test_what_is_lost_without_products_is_told() -> None:
    """Largest product 0.004 over the smallest moment 0.019: 21 %."""
    for name in MOMENTS_ONLY:
        assert "21 % of the smallest moment" in FORMATS[name].text(controller_load(SPECIAL["unlike entries"]))
    assert "Products" not in FORMATS["ur"].text(controller_load(SPECIAL["unlike entries"]))


@pytest.mark.parametrize(
    ("vector", "words"),
    [
        ([0.01, 0, 0, 0.01, 0, 0.01, 0, 0, 0, 0.0], "a mass of 0 kg"),
        ([0.01, 0, 0, 0.01, 0, 0.01, 0, 0, 0, -2.0], "a mass of -2 kg"),
        ([0.01, 0, 0, 0.01, 0, 0.05, 0, 0, 0, 2.0], "no body has this inertia"),
    ],
)
def test_impossible_bodies_are_refused(vector: list[float], words: str) -> None:
    with pytest.raises(InputError, match=words):
        controller_load(InertialParameters(np.array(vector)))


def test_limits_of_the_formats() -> None:
    heavy = controller_load(InertialParameters.from_com(4000.0, [0, 0, 1.0], np.diag([140.0, 130.0, 135.0])))
    with pytest.raises(InputError, match="refuses more than 133"):
        FORMATS["ur"].text(heavy)
    point = controller_load(InertialParameters.from_com(1.0, [0, 0, 0.1], np.zeros((3, 3))))
    with pytest.raises(InputError, match="MuJoCo refuses"):
        FORMATS["mjcf"].text(point)
    with pytest.raises(InputError, match="metres per unit must be positive"):
        replace(point, meters_per_unit=0.0)


@pytest.mark.parametrize("name", FORMATS)
def test_hostile_names_stay_in_their_comment(name: str) -> None:
    """A file name cannot end a comment, start a line of code or leave ASCII."""
    source = "a--->\n*/ x := 1;\x1b[2J\x01\\"
    load = replace(controller_load(SPECIAL["unlike entries"]), source=source, frame='tool0 µ "quoted"')
    check(name, load, SPECIAL["unlike entries"])
    text = FORMATS[name].text(load)
    assert text.isascii()
    assert "".join(text.split("\n")).isprintable()
    assert not any(line.startswith(("*/", " x")) for line in text.splitlines())


BODY = InertialParameters.from_com(3.0, [0.02, 0.05, 0.11], np.diag([0.02, 0.03, 0.025]) + 0.002 * np.ones((3, 3)))


def run(*arguments: str) -> Ended:
    return typed(["export", *arguments])


def estimate(method: int, mass: float, estimator: str = "wls", body: InertialParameters = BODY) -> dict[str, Any]:
    heavier = InertialParameters(ten_parameters(mass, body.com, body.inertia_com))
    return {"method": method, "estimator": estimator, "parameters": heavier.named()}


@pytest.fixture
def payload(tmp_path: Path) -> Callable[..., str]:
    def write(*estimates: dict[str, Any], **more: Any) -> str:
        document = {
            "frame": "tool0: the bare flange, z out of it",
            "estimates": estimates or [estimate(4, 3.0)],
            "verdict": {"level": "use", "reasons": []},
        }
        path = tmp_path / "payload.json"
        path.write_text(json.dumps(document | more), encoding="utf-8")
        return str(path)

    return write


@pytest.mark.parametrize("name", FORMATS)
def test_every_format(payload: Callable[..., str], tmp_path: Path, name: str) -> None:
    target = tmp_path / "load.txt"
    status, out, err = run(payload(), "--to", name, "--out", str(target))
    assert (status, out) == (0, "")
    text = target.read_text(encoding="utf-8")
    assert PARSERS[name](text).mass == pytest.approx(3.0)
    assert "payload.json, method 4 (wls)" in text
    assert err == ""
    status, out, _ = run(payload(), "--to", name)
    assert (status, out) == (0, text)


def test_the_recommended_method_comes_first_unless_another_is_asked_for(payload: Callable[..., str]) -> None:
    estimates = [estimate(m, float(m), kind) for m in (1, 3, 4) for kind in ("wls", "constrained")]
    path = payload(*estimates, recommended={"method": 3, "estimator": "constrained"})
    assert "method 3 (constrained)" in run(path, "--to", "ur")[1]
    assert "method 1 (constrained)" in run(path, "--to", "ur", "--method", "1")[1]
    status, _, err = run(payload(*estimates, recommended=[4]), "--to", "ur")
    assert status == 2
    assert "key 'recommended': must be a table, got [4]: give the file that --json of 'dynident payload'" in err


def test_do_not_use_is_not_written(payload: Callable[..., str], tmp_path: Path) -> None:
    target = tmp_path / "load.txt"
    path = payload(verdict={"level": "do_not_use", "reasons": ["masses spread"]})
    status, out, err = run(path, "--to", "ur", "--out", str(target))
    assert (status, out) == (1, "")
    assert not target.exists()
    assert "masses spread" in err
    status, out, _ = run(path, "--to", "ur", "--despite-verdict")
    assert status == 0
    assert "Verdict: do not use" in out


def test_what_the_arm_does_not_carry_needs_the_word(payload: Callable[..., str], tmp_path: Path) -> None:
    """A mass beyond the rated payload, an estimate's error allowed; on both sides of it, and for every format."""
    target = tmp_path / "load"
    for name in FORMATS:
        status, out, err = run(payload(rated_payload_kg=2.8), "--to", name, "--out", str(target))
        assert (status, out) == (1, "")
        assert "a mass of 3 kg, the arm carries 2.8 kg; --despite-verdict writes it all the same" in err
        assert not target.exists()
        assert run(payload(rated_payload_kg=2.8), "--to", name, "--despite-verdict")[0] == 0
        for rated in (2.86, 12.5, None):
            assert run(payload(rated_payload_kg=rated), "--to", name)[0] == 0


@pytest.mark.parametrize(
    ("kind", "value", "words"),
    [
        ("M", 1e308, "nothing that an arm carries"),
        ("M", 1e5, "nothing that an arm carries"),
        ("MX", 1e308, "nothing that an arm carries"),
        ("MX", 40.0, "nothing that an arm carries"),
        ("XX", 1e308, "are nothing that"),
        ("XX", "0.1", "finite number"),
        ("M", "3", "finite number"),
        ("M", True, "finite number"),
    ],
)
def test_numbers_that_no_arm_carries_are_refused(
    payload: Callable[..., str], kind: str, value: Any, words: str
) -> None:
    """Whatever is said of the verdict; text in the place of a number is told by its key."""
    entry = estimate(4, 3.0)
    entry["parameters"][kind] = value
    for word in ((), ("--despite-verdict",)):
        status, out, err = run(payload(entry), "--to", "ur", *word)
        assert (status, out) == (2, "")
        assert words in err
        assert len(err.splitlines()) == 1


def test_a_payload_frame_that_is_not_the_flange(payload: Callable[..., str]) -> None:
    """Frame 6 of the RX90 is at the wrist: its flange must be told, here 85 mm out and a quarter turn about z."""
    path = payload(frame="frame 6 (modified DH): origin at the wrist centre, z along axis 6; not the flange")
    status, _, err = run(path, "--to", "ur")
    assert status == 2
    assert "give --flange-frame" in err
    _, out, _ = run(path, "--to", "ur", "--flange-frame", "0", "0", "0.085", "0", "0", "90")
    parsed = PARSERS["ur"](out)
    np.testing.assert_allclose(parsed.com, [0.05, -0.02, 0.11 - 0.085], atol=1e-9)
    turn = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(parsed.inertia, turn @ BODY.inertia_com @ turn.T, atol=1e-9)
    assert "(0, 0, 0.085) m, (0, 0, 90) deg" in out


ROUNDED = InertialParameters.from_com(3.001234, [0.02, 0.05, 0.11], np.diag([0.0123, 0.0234, 0.0301]))


def line_of(estimate: dict[str, Any], **more: Any) -> str:
    """The command of a Universal Robots controller for a document with one estimate of method 4."""
    document = {
        "frame": "tool0: flange",
        "estimates": [{"method": 4, "parameters": ROUNDED.named()} | estimate],
        "verdict": {"level": "use", "reasons": []},
    }
    load = load_of(convert(document | more, PayloadResult), "p.json")
    return FORMATS["ur"].text(load).splitlines()[-1]


def test_an_assumed_inertia_is_not_rounded_by_what_was_measured() -> None:
    """The measured one is hardly known; the assumed one keeps its digits, the mass those of its interval."""
    loose = np.tile([-0.4, 0.6], (3, 3, 1)).tolist()
    measured = {"estimator": "constrained", "interval95": {"M": [2.97, 3.03]}, "inertia_com_interval95": loose}
    assumed = {"inertia": "box 100 x 100 x 100 mm", "parameters": ROUNDED.named()}
    line = line_of(measured, recommended={"method": 4}, assumed=assumed)
    assert line.startswith("set_target_payload(3.001,")
    inertia = [float(number) for number in line.removesuffix("])").rpartition("[")[2].split(",")]
    assert inertia == pytest.approx([0.0123, 0.0234, 0.0301, 0.0, 0.0, 0.0])


@pytest.mark.parametrize(("sigma", "mass"), [(0.02, "3.001"), (0.06, "3.0"), (0.006, "3.001")])
def test_digits_of_a_free_estimate_are_those_of_two_sigma(sigma: float, mass: str) -> None:
    """Two digits of half the interval, 0.04, 0.12 and 0.012 kg."""
    assert line_of({"estimator": "wls", "sigma": {"M": sigma}}).startswith(f"set_target_payload({mass},")
