"""MJCF (MuJoCo): a body ``payload`` inside the body ``flange``.

The inertia must be positive definite and its principal moments fulfil A + B >= C. Source: MuJoCo documentation, XML
reference, body/inertial.
"""

from ....common.errors import InputError
from ...numbers import principal_axes
from ..load import ControllerLoad, load_format
from ..xml import COMMENT, element, mjcf_inertial, xml_text

_LEAST = 1e-15  # MuJoCo's mjMINVAL: no moment of inertia may be smaller


def _write(load: ControllerLoad) -> str:
    body = element("body", {"name": "payload"}, mjcf_inertial(load.mass, load.com, load.inertia))
    world = element("worldbody", {}, element("body", {"name": "flange"}, body))
    return xml_text(element("mujoco", {"model": "payload"}, world))


def _ready(load: ControllerLoad) -> ControllerLoad:
    load = load.rounded()
    least = float(principal_axes(load.inertia)[0].min())
    if not load.point_mass and least < _LEAST:
        raise InputError(f"the smallest moment of inertia is {least:.2g} kg m^2: MuJoCo refuses so small a body")
    return load


FORMAT = load_format(
    title="MJCF (copy the body payload into the body of your flange)",
    source="MuJoCo XML reference, body/inertial",
    write=_write,
    ready=_ready,
    order="pos x, y, z; fullinertia M11, M22, M33, M12, M13, M23",
    in_part="the inertia is zero, a point mass; a moving link needs inertia of its own",
    comment=COMMENT,
)
