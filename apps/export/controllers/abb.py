"""ABB RAPID ``loaddata``: of a tool (``tload`` of tooldata) in tool0, of a grip load in the tool frame.

Source: Technical reference manual, RAPID Instructions, Functions and Data types, "loaddata" and "tooldata"; public
at docs.ros.org/en/noetic/api/abb_rapid_msgs/html/msg/LoadData.html and yumpu.com/en/document/view/5679047.
"""

from ...numbers import principal_axes, quaternion
from ..load import ControllerLoad, listed, load_format, number


@load_format(
    title="ABB loaddata (tload of tooldata in tool0; grip load in the tool frame)",
    source="RAPID reference manual, loaddata",
    holds=frozenset({"products", "tool frame"}),
    reference="principal moments about the centre of gravity, their axes turned by aom out of the frame",
    order="[mass, [cog x, y, z], [aom q1 (scalar), q2, q3, q4], ix, iy, iz]",
    units="kg, mm, kg m^2",
    in_part="ix = iy = iz = 0, the controller takes a point mass",
    comment=("! ", ""),
)
def _write(load: ControllerLoad) -> str:
    moments, axes = principal_axes(load.inertia)
    name = "payload_grip" if load.in_tool_frame else "payload_tool"
    return (
        f"PERS loaddata {name} := [{number(load.mass)}, [{listed(1e3 * load.com)}], "
        f"[{listed(quaternion(axes))}], {listed(moments, load.moment_digits)}];"
    )
