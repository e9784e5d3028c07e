"""SDFormat: a model of one link ``payload``, its origin at the flange.

Without entries of the inertia SDFormat takes 1 kg m^2, so a point mass needs explicit zeros. Source:
sdformat.org/spec, link/inertial (element descriptions in sdf/1.x/inertial.sdf), and gz-math, Inertial.
"""

from ..load import ControllerLoad, load_format
from ..xml import COMMENT, element, sdf_inertial, xml_text


def _write(load: ControllerLoad) -> str:
    link = element("link", {"name": "payload"}, sdf_inertial(load.mass, load.com, load.inertia))
    return xml_text(element("sdf", {"version": "1.7"}, element("model", {"name": "payload"}, link)))


FORMAT = load_format(
    title="SDFormat (fix the link payload to the flange of your robot, origin on origin)",
    source="sdformat.org/spec, inertial",
    write=_write,
    order="pose x, y, z, roll, pitch, yaw; ixx, ixy, ixz, iyy, iyz, izz, entries of the matrix",
    in_part="the inertia is zero, a point mass (left out it would be 1 kg m^2); simulators may ask for one of "
    "your own",
    comment=COMMENT,
)
