"""URDF: a link ``payload`` fixed to the link ``tool0``; its inertial origin is not turned.

Source: URDF specification, wiki.ros.org/urdf/XML/link, and wiki.ros.org/urdf/Tutorials (inertia, sign of products).
"""

from ..load import ControllerLoad, load_format
from ..xml import COMMENT, element, urdf_inertial, xml_text


def _write(load: ControllerLoad) -> str:
    joint = element(
        "joint", {"name": "tool0-payload", "type": "fixed"},
        element("parent", {"link": "tool0"}),
        element("child", {"link": "payload"}),
        element("origin", {"xyz": "0 0 0", "rpy": "0 0 0"}),
    )  # fmt: skip
    link = element("link", {"name": "payload"}, urdf_inertial(load.mass, load.com, load.inertia))
    return xml_text(element("robot", {"name": "payload"}, element("link", {"name": "tool0"}), joint, link))


FORMAT = load_format(
    title="URDF (copy joint and link payload into your robot, whose flange link is tool0 here)",
    source="wiki.ros.org/urdf/XML/link",
    write=_write,
    order="ixx, ixy, ixz, iyy, iyz, izz, entries of the matrix (ixy = -integral of x y dm)",
    in_part="the inertia is zero, a point mass; simulators may ask for one of your own",
    comment=COMMENT,
)
