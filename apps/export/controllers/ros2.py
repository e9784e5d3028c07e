"""A call of the service ``set_payload`` of Universal Robots' ROS 2 driver.

Messages before 2026 have mass and centre of gravity alone; the rolling distribution's has one field ``payload``, a
geometry_msgs/Inertia. Source: docs.ros.org/en/jazzy/p/ur_msgs/srv/SetPayload.html and
UniversalRobots/Universal_Robots_ROS2_Driver, pull request 1811.
"""

from ...numbers import ENTRIES
from ..load import ControllerLoad, load_format, number
from . import ur

_SERVICE = "/io_and_status_controller/set_payload ur_msgs/srv/SetPayload"


def _write(load: ControllerLoad) -> str:
    x, y, z = (number(value) for value in load.com)
    fields = [f"mass: {number(load.mass)}", f"center_of_gravity: {{x: {x}, y: {y}, z: {z}}}"]
    if not load.point_mass:
        names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
        fields += [f"{name}: {number(value)}" for name, value in zip(names, load.inertia[ENTRIES], strict=True)]
    return f'ros2 service call {_SERVICE} "{{{", ".join(fields)}}}"'


FORMAT = load_format(
    title="Universal Robots ROS 2 driver, service set_payload",
    source="ur_msgs/srv/SetPayload of 2026 (older ones lack the inertia: leave ixx to iyz out)",
    write=_write,
    ready=ur.ready,
    reference="inertia matrix about the centre of gravity, axes of the tool flange",
    order="mass, center_of_gravity, ixx to iyz by name, entries of the matrix (ixy = -integral of x y dm)",
    in_part="the inertia is left out, the driver takes zero",
)
