"""KUKA ``LOAD_DATA``; a negative mass stands for the arm's default load.

Source: load definition in the manuals of the arms (KR IONTEC, "Load center of gravity and mass moment of inertia",
easymanua.ls/kuka/iontec-kr-20-r3100/manual?p=40) and KRC_WriteLoadData
(infosys.beckhoff.com/content/1033/tf5120/13081587595.html).
"""

import math

import numpy as np

from ....model import Pose
from ...numbers import principal_axes
from ..load import ControllerLoad, load_format, number

_TURNS = 4  # decimals of angles [deg] of a rounded inertia


@load_format(
    title="KUKA LOAD_DATA (config.dat; put the number of your tool for 1)",
    source="load data in the manuals of the arms (KUKA.Load)",
    reference="principal moments about the centre of mass, their axes turned by A, B, C out of the flange frame",
    order="M, CM {X, Y, Z, A about z, B about new y, C about newest x}, J {X, Y, Z}",
    units="kg, mm, deg, kg m^2",
    in_part="J = 0, a point mass",
    comment=("; ", ""),
)
def _write(load: ControllerLoad) -> str:
    moments, axes = principal_axes(load.inertia)
    x, y, z = (number(1e3 * value) for value in load.com)
    turns = None if load.moment_digits is None else _TURNS
    c, b, a = (number(math.degrees(angle), turns) for angle in Pose.of(axes, np.zeros(3)).rpy)
    jx, jy, jz = (number(value, load.moment_digits) for value in moments)
    centre = f"CM {{X {x},Y {y},Z {z},A {a},B {b},C {c}}}"
    return f"LOAD_DATA[1]={{M {number(load.mass)},{centre},J {{X {jx},Y {jy},Z {jz}}}}}"
