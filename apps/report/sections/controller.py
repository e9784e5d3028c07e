"""Texts to type into the controller, in a few formats that open and can be copied."""

from dataclasses import replace

from ....common.errors import InputError
from ....estimation.results.payload import PayloadResult
from ...export.controllers import FORMATS
from ...export.format import Format
from ...export.load import ControllerLoad, load_of
from ...numbers import six
from ..blocks import Block, Code, Details, Text

_SHOWN = ("abb", "kuka", "ur", "fanuc", "yaskawa", "staubli", "franka", "urdf")
"""The formats in the page; 'dynident export' writes more."""
_MAKERS = {"abb": "abb", "kuka": "kuka", "universal robots": "ur", "fanuc": "fanuc", "yaskawa": "yaskawa",
           "motoman": "yaskawa", "stäubli": "staubli", "staubli": "staubli", "franka": "franka"}  # fmt: skip
"""Word in a robot's title -> its format."""


def controller_blocks(result: PayloadResult, name: str, title: str) -> list[Block]:
    """The recommended payload in the formats of controllers; the robot's own maker's is open.

    Args:
        name: what the formats call its source.
        title: of the robot, in which its maker is looked for.
    """
    try:
        load = load_of(result, name)
    except InputError as error:
        return [Text(f"No controller takes this payload: {error}.")]
    if load.verdict == "do_not_use":
        return [Text("Nothing is given here: the numbers must not be used. Read the reasons and record again.")]
    at_flange = load.in_flange()
    if at_flange is None:
        where = (
            f"The payload is known in {load.frame}, not in the flange that controllers ask for. Its numbers there:"
        )
        how = (
            "'dynident export payload.json --to NAME --flange-frame X Y Z RX RY RZ' writes them for a controller, "
            "given the flange's pose in that frame."
        )
        return [Text(where), Code("controller-plain", _plain_text(load)), Text(how)]
    # The reasons stand beside it.
    load = replace(at_flange, reasons=())
    maker = next((form for word, form in _MAKERS.items() if word in title.lower()), None)
    only = Text("Mass and centre of mass only: the inertia was not measured well enough.", "note")
    formats: list[Block] = [_format(FORMATS[form], load, False) for form in _SHOWN if form != maker]
    more = ", ".join(form for form in FORMATS if form not in _SHOWN)
    formats.append(Text(f"'dynident export --to' also writes {more}.", "note"))
    return [
        *([only] if load.point_mass else []),
        *([_format(FORMATS[maker], load, True)] if maker else []),
        Details("Other controllers and files" if maker else "Controllers and files", formats, not maker),
    ]


def _format(form: Format[ControllerLoad], load: ControllerLoad, opened: bool) -> Details:
    try:
        text = form.text(load)
    except InputError as error:
        return Details(form.title, [Text(f"This controller would refuse it: {error}.")])
    return Details(form.title, [Code(f"controller-{form.name}", text.rstrip("\n"))], opened)


def _plain_text(load: ControllerLoad) -> str:
    x, y, z = (f"{value + 0.0:.5f}" for value in load.com)
    lines = [f"mass {load.mass:.4f} kg", f"centre of mass {x} {y} {z} m"]
    if not load.point_mass:
        names = ("xx", "yy", "zz", "xy", "xz", "yz")
        lines.append("inertia at the centre of mass, kg m^2, axes of that frame:")
        lines += [f"  {name} {value + 0.0:.6f}" for name, value in zip(names, six(load.inertia), strict=True)]
    return "\n".join(lines)
