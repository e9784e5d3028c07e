"""Friction of drives, a list of terms: each is a parameter times a law of speed, position and load.

The paper's terms are Coulomb and viscous friction (2). Gears also rub in proportion to the torque that they carry
(Hamon, Gautier, Garrec: Dynamic identification of robots with a dry friction model depending on load and velocity,
IROS 2010), and lubricated contacts grow more slowly than their speed.
"""

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from ..common import InputError


class Law(NamedTuple):
    """Factor of the parameter of a built-in term."""

    title: str
    unit: str
    value: Callable[[Any, Any, Any, float], Any]  # of speed, its sign, load, own speed, as arrays or expressions
    loaded: bool = False  # whether the load counts


_TINY = 1e-16  # added to a speed under a root, whose derivative at rest is infinite


def _abs(value: Any) -> Any:
    """Absolute value; the expressions of CasADi before 3.8 know no ``abs``."""
    return ca.fabs(value) if isinstance(value, (ca.SX, ca.MX)) else abs(value)


LAWS = {
    "FS": Law("Coulomb", "N·m or N", lambda v, sign, load, own: sign),
    "FV": Law("viscous", "N·m·s or N·s/m", lambda v, sign, load, own: v),
    "FL": Law("load", "1", lambda v, sign, load, own: _abs(load) * sign, loaded=True),
    "FR": Law("root", "N·m/(rad/s)^.5 or N/(m/s)^.5", lambda v, sign, load, own: (_abs(v) + _TINY) ** 0.5 * sign),
    "FB": Law("Stribeck", "N·m or N", lambda v, sign, load, own: math.e ** (-((v / own) ** 2)) * sign),
    "FA": Law("asymmetric Coulomb", "N·m or N", lambda v, sign, load, own: _abs(sign)),
}
"""The built-in terms: (2), then load FL |tau| sign(qd), root FR sqrt|qd| sign(qd), Stribeck FB exp(-(qd/speed)^2)
sign(qd), and FA |sign(qd)|, by which Coulomb friction differs from one direction to the other."""
_KNOWN = (
    f"give terms such as FS,FV,FL1,FB@0.1, of {', '.join(f'{kind} ({law.title})' for kind, law in LAWS.items())}"
)
_NAME = re.compile(r"(F[A-Z]+)([1-9]\d*)?(?:@(\d*\.?\d+(?:[eE][+-]?\d+)?))?(?:=(.*):([a-z]+))?")


@dataclass(frozen=True)
class Friction:
    """Term of the friction of a joint or of all.

    Attributes:
        kind: what its parameters are called, "FL" of FL2: one of ``LAWS``, or another that begins with F.
        joint: number of the joint that has it; 0 for all.
        speed: at which the Stribeck term has fallen to 1/e [rad/s or m/s]; of no other term.
        unit: of the parameter of a law of one's own.
        code: such a law, as ``Friction.of`` writes it.
    """

    kind: str
    joint: int = 0
    speed: float = 0.0
    unit: str = ""
    code: str = ""

    def __post_init__(self) -> None:
        if not re.fullmatch(r"F[A-Z]+", self.kind) or self.kind in ("FSM", "FVM"):
            raise InputError(f"friction {self.kind!r}: its name must be F and more capitals, and not FSM or FVM")
        if (self.kind in LAWS) == bool(self.code):
            raise InputError(f"friction {self.kind!r}: {_KNOWN}, or a law of your own")
        if (self.speed > 0.0) != (self.kind == "FB"):
            raise InputError(f"friction {self.kind!r}: FB needs a speed, FB@0.1; no other term has one")

    @staticmethod
    def of(kind: str, unit: str, law: ca.Function, joint: int = 0) -> "Friction":
        """Make a term of one's own.

        Args:
            kind: what its parameters are called, "FD".
            unit: of the parameter.
            law: function of the joint's speed [rad/s or m/s], position [rad or m] and load, the torque of links,
                payload and spring that the gear carries [N·m or N], to what multiplies the parameter.
            joint: number of the joint that has it; all by default.

        Raises:
            InputError: if it is a function of something else.
        """
        sizes = [law.numel_in(k) for k in range(law.n_in())] + [law.numel_out(k) for k in range(law.n_out())]
        if law.n_in() != 3 or sizes != [1, 1, 1, 1]:
            raise InputError(f"friction {kind!r}: its law must take speed, position and load and give one number")
        return Friction(kind, joint, unit=unit, code=law.serialize())

    @property
    def loaded(self) -> bool:
        """True if the term depends on the torque that the gear carries."""
        return bool(_law(self.code).jac_sparsity(0, 2).nnz()) if self.code else LAWS[self.kind].loaded

    def at(self, joint: int) -> bool:
        """True if a joint (from 1) has the term."""
        return self.joint in (0, joint)

    def value(self, speed: Any, sign: Any, position: Any, load: Any) -> Any:
        """Factor of the term's parameter, of NumPy arrays or CasADi expressions."""
        if not self.code:
            return LAWS[self.kind].value(speed, sign, load, self.speed)
        law = _law(self.code)
        if not isinstance(speed, np.ndarray):
            return law(speed, position, load)
        rows = (np.broadcast_to(x, speed.shape)[None] for x in (speed, position, load))
        return law.map(len(speed))(*rows).full()[0]


PAPER = (Friction("FS"), Friction("FV"))
"""Coulomb and viscous friction (2)."""


def is_friction(name: str) -> bool:
    """True if a parameter is one of friction, a constant torque among it."""
    return name.startswith(("F", "OFF"))


def friction_terms(names: Sequence[str]) -> tuple[Friction, ...]:
    """Read terms: "FS" for all joints, "FL2" for joint 2 alone, "FB@0.1" with its speed, "FX=unit:code".

    Raises:
        InputError: for a name that stands for no term.
    """
    terms = []
    for name in names:
        found = _NAME.fullmatch(name.strip())
        if not found:
            raise InputError(f"friction {name.strip()[:40]!r}: {_KNOWN}")
        kind, joint, speed, unit, code = found.groups()
        terms.append(Friction(kind, int(joint or 0), float(speed or 0.0), unit or "", code or ""))
    return tuple(dict.fromkeys(terms))


def term_names(terms: Sequence[Friction]) -> tuple[str, ...]:
    """Name terms as ``friction_terms`` reads them."""
    names = []
    for term in terms:
        speed, law = f"@{term.speed}" * bool(term.speed), f"={term.unit}:{term.code}" * bool(term.code)
        names.append(f"{term.kind}{term.joint or ''}{speed}{law}")
    return tuple(names)


def terms_of(names: Sequence[str], own: Sequence[Friction], joints: int) -> tuple[Friction, ...]:
    """Read the friction of a model from the names of its parameters, base or standard ones.

    ``own``: terms of the robot's description, which tell what no name does: a Stribeck speed, a law of one's own.
    """
    described = [term for term in own if term.speed or term.code]
    terms = []
    for term in (*(Friction(kind) for kind in LAWS if kind != "FB"), *described):
        there = tuple(j for j in range(1, joints + 1) if term.at(j) and f"{term.kind}{j}" in names)
        if there:
            terms += [replace(term, joint=j) for j in (there if len(there) < joints else (0,))]
    return tuple(terms)


@lru_cache(maxsize=64)
def _law(code: str) -> ca.Function:
    try:
        return ca.Function.deserialize(code)
    except RuntimeError as error:
        raise InputError(f"a law of friction cannot be read: {error}") from None
