"""Who decided the numbers of a URDF's links, as comments in it: for readers, and for programs line by line."""

import math
from collections.abc import Iterator

from ..estimation.possible import DECIDER, Gauge, Labelled, RobotOrigins

_INDENT = "    "


def origins_legend(origins: RobotOrigins) -> Iterator[str]:
    """What the comments beside the links say, for the head of the file; then the base parameters."""
    alone = DECIDER[origins.gauge]
    yield (
        "Beside each link, a line a number: name, value, who decided it, the data's share of it (0 to 1), and the "
        "base parameters it is part of. 'data': these alone determine it. 'combination': they determine it only "
        f"together with others, the rest is the {alone}'s choice. '{alone}': no motion shows it, the data "
        "say nothing. First the URDF's own numbers (mass, x y z of the centre of mass, inertia there), then the "
        "standard parameters in the link's modified DH frame, those of its drive among them."
    )
    yield f"Base parameters: {'; '.join(origins.groupings)}."


def origins_comment(origins: RobotOrigins, link: int) -> Iterator[str]:
    """One comment of a link (from 0), a line a number: ``name value decided-by share base,base`` (or ``none``)."""
    _, body, parameters = origins.links[link]
    yield f"{_INDENT}<!-- numbers of this link, decided by:"
    yield from (_line(name, number, origins.gauge) for name, number in body.items())
    yield f"{_INDENT}standard parameters, modified DH frame, decided by:"
    yield from (_line(name, number, origins.gauge) for name, number in parameters.items())
    yield f"{_INDENT}-->"


def _line(name: str, number: Labelled, gauge: Gauge) -> str:
    value, origin = number
    who = {"identified": "data", "combination": "combination", "prior": DECIDER[gauge]}[origin.kind]
    share = math.floor(1000.0 * origin.share) / 1000.0  # 1 is for what the data determine
    return f"{_INDENT}  {name} {value + 0.0!r} {who} {share:.3f} {','.join(origin.base) or 'none'}"
