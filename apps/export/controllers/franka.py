"""Franka ``Robot::setLoad`` of libfranka.

setLoad(load_mass, F_x_Cload, load_inertia): mass [kg]; centre of mass in the flange frame [m]; 3 x 3 inertia [kg
m^2], column-major. It is the load beside the end effector set in Desk, not instead of it. Sources: libfranka,
robot.h; docs.ros.org/en/humble/p/franka_msgs/srv/SetLoad.html.
"""

from .form import ControllerFormat, number, numbers
from .load import ControllerLoad


def _write(load: ControllerLoad) -> str:
    return (
        f"robot.setLoad({number(load.mass)}, {{{{{numbers(load.com)}}}}},\n"
        f"              {{{{{numbers(load.inertia.ravel(order='F'))}}}}});"
    )


FORMAT = ControllerFormat(
    name="franka",
    title="Franka Robot::setLoad (libfranka, C++; beside the end effector set in Desk)",
    reference="inertia matrix about the centre of mass, axes of the flange",
    order="load_mass, F_x_Cload {x, y, z}, load_inertia column by column (Ixx Iyx Izx Ixy Iyy Izy Ixz Iyz Izz)",
    units="kg, m, kg m^2",
    point_mass="the inertia is zero, a point mass",
    source="libfranka, robot.h, setLoad",
    write=_write,
    comment=("// ", ""),
)
