"""Universal Robots: ``set_target_payload`` of URScript, and a call of their ROS 2 driver's service ``set_payload``.

set_target_payload(m, cog, inertia): mass [kg]; cog [m] from the tool mount; inertia [Ixx, Iyy, Izz, Ixy, Ixz, Iyz]
[kg m^2] with origin in the cog and axes aligned with the flange's; left out, it is zero. Components beyond +-133
kg m^2 and negative moments raise an exception. Source: URScript manual, set_target_payload
(universal-robots.com/manuals/EN/HTML/SW10_6/Content/prod-scriptmanual/G5/set_target_payload.htm).

ur_msgs/srv/SetPayload: mass [kg]; center_of_gravity [m] from the tool mount; ixx, iyy, izz, ixy, ixz, iyz
[kg m^2] about the centre of gravity, axes aligned with the flange's, as ``set_target_payload`` takes them;
transition_time. Messages before 2026 have mass and centre of gravity alone; the rolling distribution's has one
field ``payload``, a geometry_msgs/Inertia. Source: docs.ros.org/en/jazzy/p/ur_msgs/srv/SetPayload.html and
UniversalRobots/Universal_Robots_ROS2_Driver, pull request 1811.
"""

import numpy as np

from ....common.errors import InputError
from ...numbers import six
from .form import ControllerFormat, number, numbers
from .load import ControllerLoad

_MOST = 133.0  # kg m^2, of each component
_SERVICE = "/io_and_status_controller/set_payload ur_msgs/srv/SetPayload"
_SIX = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def _write(load: ControllerLoad) -> str:
    arguments = f"{number(load.mass)}, [{numbers(load.com)}]"
    if not load.point_mass:
        arguments += f", [{numbers(six(load.inertia))}]"
    return f"set_target_payload({arguments})"


def check_moments(load: ControllerLoad) -> None:
    """Refuse components that the controller raises an exception for."""
    worst = float(np.abs(load.inertia).max())
    if worst > _MOST:
        raise InputError(f"the inertia reaches {worst:.4g} kg m^2; set_target_payload refuses more than {_MOST:g}")


def _write_call(load: ControllerLoad) -> str:
    x, y, z = (number(float(value)) for value in load.com)
    fields = [f"mass: {number(load.mass)}", f"center_of_gravity: {{x: {x}, y: {y}, z: {z}}}"]
    if not load.point_mass:
        entries = zip(_SIX, six(load.inertia), strict=True)
        fields += [f"{name}: {number(float(value))}" for name, value in entries]
    return f'ros2 service call {_SERVICE} "{{{", ".join(fields)}}}"'


FORMAT = ControllerFormat(
    name="ur",
    title="Universal Robots set_target_payload",
    reference="inertia matrix about the centre of gravity, axes of the tool flange",
    order="m, [cog x, y, z], [Ixx, Iyy, Izz, Ixy, Ixz, Iyz], entries of the matrix (Ixy = -integral of x y dm)",
    units="kg, m, kg m^2",
    point_mass="the inertia is left out, the controller takes zero",
    source="URScript manual, set_target_payload",
    write=_write,
    comment=("# ", ""),
    check=check_moments,
)
ROS2 = ControllerFormat(
    name="ros2",
    title="Universal Robots ROS 2 driver, service set_payload",
    reference="inertia matrix about the centre of gravity, axes of the tool flange",
    order="mass, center_of_gravity, ixx to iyz by name, entries of the matrix (ixy = -integral of x y dm)",
    units="kg, m, kg m^2",
    point_mass="the inertia is left out, the driver takes zero",
    source="ur_msgs/srv/SetPayload of 2026 (older ones lack the inertia: leave ixx to iyz out)",
    write=_write_call,
    comment=("# ", ""),
    check=check_moments,
)
