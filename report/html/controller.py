"""What to type into the controller: a few formats, each to be opened and copied."""

from __future__ import annotations

from dataclasses import replace

from ...common.errors import InputError
from ...estimation.files import StoredPayload
from ..controllers import FORMATS, ControllerFormat, ControllerLoad, load_of_document
from ..controllers.form import six
from ..controllers.payload_file import is_flange
from .markup import Html, joined, paragraph, tag
from .provenance import copyable

_SHOWN = ("abb", "kuka", "ur", "fanuc", "yaskawa", "staubli", "franka", "urdf")
"""The formats in the page; 'dynident export' writes more."""
_MAKERS = {"abb": "abb", "kuka": "kuka", "universal robots": "ur", "fanuc": "fanuc", "yaskawa": "yaskawa",
           "motoman": "yaskawa", "stäubli": "staubli", "staubli": "staubli", "franka": "franka"}  # fmt: skip
"""Word in a robot's title -> its format."""


def controller_block(document: StoredPayload, name: str, title: str) -> Html:
    """The recommended payload in the formats of controllers; the robot's own maker's is open.

    Args:
        document: of ``dynident payload --json``.
        name: what the formats call its source.
        title: of the robot, in which its maker is looked for.
    """
    try:
        load = load_of_document(document, name)
    except InputError as error:
        return paragraph(f"No controller takes this payload: {error}.")
    if load.verdict == "do_not_use":
        return paragraph("Nothing is given here: the numbers must not be used. Read the reasons and record again.")
    if not is_flange(load.frame):
        return joined(
            paragraph(
                f"The payload is known in {load.frame}, not in the flange that controllers ask for. Its numbers "
                "there:"
            ),
            copyable("controller-plain", _plain_text(load)),
            paragraph(
                "'dynident export payload.json --to NAME --flange-frame X Y Z RX RY RZ' writes them for a "
                "controller, given the flange's pose in that frame."
            ),
        )
    # The reasons stand beside it.
    load = replace(load, reasons=())
    own = next((form for word, form in _MAKERS.items() if word in title.lower()), None)
    mine = _format(FORMATS[own], load, True) if own else Html()
    others = [_format(FORMATS[one], load, False) for one in _SHOWN if one != own]
    more = f"'dynident export --to' also writes {', '.join(one for one in FORMATS if one not in _SHOWN)}."
    only = "Mass and centre of mass only: the inertia was not measured well enough."
    others.append(paragraph(more, class_="note"))
    rest = tag(
        "details",
        tag("summary", "Other controllers and files" if own else "Controllers and files"),
        *others,
        **({} if own else {"open": "open"}),
    )
    return joined(paragraph(only, class_="note") if load.point_mass else Html(), mine, rest)


def _format(form: ControllerFormat, load: ControllerLoad, opened: bool) -> Html:
    title = tag("summary", form.title)
    try:
        text = form.text(load)
    except InputError as error:
        return tag("details", title, paragraph(f"This controller would refuse it: {error}."))
    head = Html()
    if form.comment is None and not form.head_inside:
        head = joined(*(paragraph(line, class_="note") for line in form.head(load)))
    content = joined(title, head, copyable(f"controller-{form.name}", text.rstrip("\n")))
    return tag("details", content, **({"open": "open"} if opened else {}))


def _plain_text(load: ControllerLoad) -> str:
    x, y, z = (f"{value + 0.0:.5f}" for value in load.com)
    lines = [f"mass {load.mass:.4f} kg", f"centre of mass {x} {y} {z} m"]
    if not load.point_mass:
        names = ("xx", "yy", "zz", "xy", "xz", "yz")
        lines.append("inertia at the centre of mass, kg m^2, axes of that frame:")
        lines += [f"  {name} {value + 0.0:.6f}" for name, value in zip(names, six(load.inertia), strict=True)]
    return "\n".join(lines)
