"""Franka ``Robot::setLoad`` of libfranka: the load beside the end effector set in Desk, not instead of it.

Sources: libfranka, robot.h; docs.ros.org/en/humble/p/franka_msgs/srv/SetLoad.html.
"""

from ..load import ControllerLoad, listed, load_format, number


@load_format(
    title="Franka Robot::setLoad (libfranka, C++; beside the end effector set in Desk)",
    source="libfranka, robot.h, setLoad",
    order="load_mass, F_x_Cload {x, y, z}, load_inertia column by column (Ixx Iyx Izx Ixy Iyy Izy Ixz Iyz Izz)",
    in_part="the inertia is zero, a point mass",
    comment=("// ", ""),
)
def _write(load: ControllerLoad) -> str:
    return (
        f"robot.setLoad({number(load.mass)}, {{{{{listed(load.com)}}}}},\n"
        f"              {{{{{listed(load.inertia.ravel(order='F'))}}}}});"
    )
