"""Reads the formats back, each written from its documentation alone; rotations by SciPy."""

import re
import xml.etree.ElementTree as ET
from collections.abc import Callable
from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from dynident.common.arrays import Array
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
