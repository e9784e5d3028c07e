"""URDF: a link ``payload`` fixed to the link ``tool0``.

The inertial origin stands at the centre of mass without rotation, so that ixx, ixy, ixz, iyy, iyz, izz are the
entries of the inertia matrix there in the axes of the flange (ixy = -integral of x y dm). Source: URDF
specification, wiki.ros.org/urdf/XML/link, and wiki.ros.org/urdf/Tutorials (inertia, sign of products).
"""

from ...numbers import exact, inertia_entries
from .form import ControllerFormat
from .load import ControllerLoad


def _write(load: ControllerLoad) -> str:
    inertia = " ".join(f'{name}="{value}"' for name, value in inertia_entries(load.inertia).items())
    return f"""<robot name="payload">
  <link name="tool0"/>
  <joint name="tool0-payload" type="fixed">
    <parent link="tool0"/>
    <child link="payload"/>
    <origin xyz="0 0 0" rpy="0 0 0"/>
  </joint>
  <link name="payload">
    <inertial>
      <origin xyz="{exact(load.com)}" rpy="0 0 0"/>
      <mass value="{exact(load.mass)}"/>
      <inertia {inertia}/>
    </inertial>
  </link>
</robot>"""


FORMAT = ControllerFormat(
    name="urdf",
    title="URDF (copy joint and link payload into your robot, whose flange link is tool0 here)",
    reference="inertia matrix about the centre of mass, axes of the flange",
    order="ixx, ixy, ixz, iyy, iyz, izz, entries of the matrix (ixy = -integral of x y dm)",
    units="kg, m, kg m^2",
    point_mass="the inertia is zero, a point mass; simulators may ask for one of your own",
    source="wiki.ros.org/urdf/XML/link",
    write=_write,
    comment=("<!-- ", " -->"),
)
