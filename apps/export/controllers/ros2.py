"""Universal Robots' ROS 2 driver: a call of its service ``set_payload``.

ur_msgs/srv/SetPayload: mass [kg]; center_of_gravity [m] from the tool mount; ixx, iyy, izz, ixy, ixz, iyz
[kg m^2] about the centre of gravity, axes aligned with the flange's, as ``set_target_payload`` takes them;
transition_time. Messages before 2026 have mass and centre of gravity alone; the rolling distribution's has one
field ``payload``, a geometry_msgs/Inertia. Source: docs.ros.org/en/jazzy/p/ur_msgs/srv/SetPayload.html and
UniversalRobots/Universal_Robots_ROS2_Driver, pull request 1811.
"""

from ...numbers import six
from .form import ControllerFormat, number
from .load import ControllerLoad
from .universal_robots import check_moments

_SERVICE = "/io_and_status_controller/set_payload ur_msgs/srv/SetPayload"
_SIX = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def _write(load: ControllerLoad) -> str:
    x, y, z = (number(float(value)) for value in load.com)
    fields = [f"mass: {number(load.mass)}", f"center_of_gravity: {{x: {x}, y: {y}, z: {z}}}"]
    if not load.point_mass:
        entries = zip(_SIX, six(load.inertia), strict=True)
        fields += [f"{name}: {number(float(value))}" for name, value in entries]
    return f'ros2 service call {_SERVICE} "{{{", ".join(fields)}}}"'


FORMAT = ControllerFormat(
    name="ros2",
    title="Universal Robots ROS 2 driver, service set_payload",
    reference="inertia matrix about the centre of gravity, axes of the tool flange",
    order="mass, center_of_gravity, ixx to iyz by name, entries of the matrix (ixy = -integral of x y dm)",
    units="kg, m, kg m^2",
    point_mass="the inertia is left out, the driver takes zero",
    source="ur_msgs/srv/SetPayload of 2026 (older ones lack the inertia: leave ixx to iyz out)",
    write=_write,
    comment=("# ", ""),
    check=check_moments,
)
