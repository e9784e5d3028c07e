"""ABB RAPID ``loaddata``.

[mass, cog, aom, ix, iy, iz]: mass [kg]; cog [mm]; aom, the quaternion of the principal axes at the centre of
gravity; principal moments there [kg m^2]. Of a tool (``tload`` of tooldata) in the wrist frame tool0, of a grip
load in the tool frame. Source: Technical reference manual, RAPID Instructions, Functions and Data types,
"loaddata" and "tooldata"; public at docs.ros.org/en/noetic/api/abb_rapid_msgs/html/msg/LoadData.html and
yumpu.com/en/document/view/5679047.
"""

from .form import ControllerFormat, moment_digits, number, numbers
from .load import ControllerLoad
from .rotation import quaternion


def _write(load: ControllerLoad) -> str:
    moments, axes = load.principal
    name = "payload_grip" if load.in_tool_frame else "payload_tool"
    return (
        f"PERS loaddata {name} := [{number(load.mass)}, [{numbers(1e3 * load.com)}], "
        f"[{numbers(quaternion(axes))}], {numbers(moments, moment_digits(load))}];"
    )


FORMAT = ControllerFormat(
    name="abb",
    title="ABB loaddata (tload of tooldata in tool0; grip load in the tool frame)",
    reference="principal moments about the centre of gravity, their axes turned by aom out of the frame",
    order="[mass, [cog x, y, z], [aom q1 (scalar), q2, q3, q4], ix, iy, iz]",
    units="kg, mm, kg m^2",
    point_mass="ix = iy = iz = 0, the controller takes a point mass",
    source="RAPID reference manual, loaddata",
    write=_write,
    comment=("! ", ""),
    in_tool_frame=True,
)
