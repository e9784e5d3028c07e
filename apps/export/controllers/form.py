"""What every format has, and the text it becomes: a head that says what the numbers mean, then the numbers."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .... import __version__
from ....common.arrays import Array
from ....common.errors import printable
from .load import ControllerLoad

_DIGITS = 10
"""Significant digits where a hand may type them and no interval says how many there are."""


@dataclass(frozen=True)
class ControllerFormat:
    """A format that a payload can be written in.

    Attributes:
        name: on the command line.
        title: whose format it is.
        reference: of which point and in which axes the inertia is.
        order: of the numbers.
        units: of the numbers.
        point_mass: what the format makes of mass and centre of mass alone.
        source: where the format is documented.
        comment: what goes before and after a line of comment.
        first_line: what must stand before the comments.
        loses_products: whether products of inertia have no place.
        in_tool_frame: whether it can be told in a tool's frame.
        own_units: whether lengths are in the file's own units.
        check: refuses what the controller would refuse.
    """

    name: str
    title: str
    reference: str
    order: str
    units: str
    point_mass: str
    source: str
    write: Callable[[ControllerLoad], str]
    comment: tuple[str, str]
    first_line: str = ""
    loses_products: bool = False
    in_tool_frame: bool = False
    own_units: bool = False
    check: Callable[[ControllerLoad], None] | None = None

    def text(self, load: ControllerLoad) -> str:
        """The whole file.

        Raises:
            InputError: if the controller would refuse the load.
        """
        load = load.rounded()
        if self.check is not None:
            self.check(load)
        lines = [self.first_line] if self.first_line else []
        before, after = self.comment
        lines += [f"{before}{_plain(line)}{after}" for line in self.head(load)]
        return "\n".join([*lines, self.write(load).rstrip("\n")]) + "\n"

    def head(self, load: ControllerLoad) -> list[str]:
        """What must be said beside the numbers."""
        load = load.rounded()
        verdict = load.verdict.replace("_", " ")
        lines = [
            f"{self.title}: payload by dynident {__version__} from {load.source}. Verdict: {verdict}.",
            *(f"  {reason}" for reason in load.reasons),
            f"Frame: {load.frame}.",
            f"Reference: {self.reference}.",
            f"Order: {self.order}.",
            f"Units: {self.units}.",
        ]
        if load.point_mass:
            lines.append(f"Mass and centre of mass only: {self.point_mass}.")
        elif self.loses_products:
            lines.append(
                f"Products of inertia have no place here: the largest is {100 * load.products_lost:.2g} % of the "
                "smallest moment."
            )
        if load.widened > 0.0:
            lines.append(
                f"A body at the edge of the possible: {load.widened:.1g} kg m^2 added to each moment, so that no "
                "rounding makes it impossible."
            )
        return [*lines, f"Format: {self.source}."]


def number(value: float, digits: int | None = None) -> str:
    """A number without exponent, always with a decimal point: every controller reads it.

    Args:
        digits: decimals to round it to; None: it has those that it should have.
    """
    value = value if digits is None else round(value, digits)
    text = np.format_float_positional(value, precision=_DIGITS, unique=False, fractional=False, trim="0")
    return "0.0" if float(text) == 0.0 else text


def numbers(values: Array, digits: int | None = None) -> str:
    """Several of them, with commas."""
    return ", ".join(number(float(value), digits) for value in np.ravel(values))


def moment_digits(load: ControllerLoad) -> int | None:
    """Decimals of moments that are worked out of a rounded inertia: one more than it has."""
    return None if load.inertia_digits is None else load.inertia_digits + 1


def _plain(line: str) -> str:
    """A comment that ends no comment, continues no line and is ASCII."""
    text = printable(" ".join(line.split())).replace("±", "+-").encode("ascii", "replace").decode("ascii")
    return text.replace("--", "- -").replace("--", "- -").replace("*/", "* /").rstrip("\\")
