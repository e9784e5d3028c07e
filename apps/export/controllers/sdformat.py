"""SDFormat: a model of one link ``payload``, its origin at the flange.

The pose of the inertial frame is the centre of mass without rotation; ixx, ixy, ixz, iyy, iyz, izz are entries of
the inertia matrix there. Without them SDFormat takes 1 kg m^2, so a point mass needs explicit zeros. Source:
sdformat.org/spec, link/inertial (element descriptions in sdf/1.x/inertial.sdf), and gz-math, Inertial.
"""

from ...numbers import exact, inertia_entries
from .form import ControllerFormat
from .load import ControllerLoad


def _write(load: ControllerLoad) -> str:
    entries = inertia_entries(load.inertia).items()
    inertia = "".join(f"\n          <{name}>{value}</{name}>" for name, value in entries)
    return f"""<sdf version="1.7">
  <model name="payload">
    <link name="payload">
      <inertial>
        <pose>{exact(load.com)} 0 0 0</pose>
        <mass>{exact(load.mass)}</mass>
        <inertia>{inertia}
        </inertia>
      </inertial>
    </link>
  </model>
</sdf>"""


FORMAT = ControllerFormat(
    name="sdf",
    title="SDFormat (fix the link payload to the flange of your robot, origin on origin)",
    reference="inertia matrix about the centre of mass, axes of the flange",
    order="pose x, y, z, roll, pitch, yaw; ixx, ixy, ixz, iyy, iyz, izz, entries of the matrix",
    units="kg, m, kg m^2",
    point_mass="the inertia is zero, a point mass (left out it would be 1 kg m^2); simulators may ask for one of "
    "your own",
    source="sdformat.org/spec, inertial",
    write=_write,
    comment=("<!-- ", " -->"),
)
