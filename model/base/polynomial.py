"""Polynomials in a robot's lengths, and sums of parameters with such factors written as text."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import groupby
from typing import Union

Scalar = Union[float, "Polynomial"]
Monomial = tuple[str, ...]
"""Factors of a monomial in alphabetical order: D3^2 is ("D3", "D3")."""

_ROUNDING = 1e-12
"""Coefficient below which it comes from rounded sines and cosines."""


@dataclass(frozen=True)
class Polynomial:
    """A polynomial in named lengths.

    Attributes:
        terms: coefficient of each monomial.
    """

    terms: Mapping[Monomial, float]

    @staticmethod
    def symbol(name: str) -> "Polynomial":
        """Polynomial of one length."""
        return Polynomial({(name,): 1.0})

    @staticmethod
    def of(value: Scalar) -> "Polynomial":
        """Make a number a polynomial; a polynomial stays as it is."""
        return value if isinstance(value, Polynomial) else Polynomial({(): float(value)})

    def __add__(self, other: Scalar) -> "Polynomial":
        """Sum with a polynomial or a number."""
        terms = dict(self.terms)
        for monomial, factor in Polynomial.of(other).terms.items():
            terms[monomial] = terms.get(monomial, 0.0) + factor
        return Polynomial({monomial: factor for monomial, factor in terms.items() if abs(factor) > _ROUNDING})

    def __mul__(self, other: Scalar) -> "Polynomial":
        """Product with a polynomial or a number."""
        product = Polynomial({})
        for left, a in self.terms.items():
            for right, b in Polynomial.of(other).terms.items():
                product += Polynomial({tuple(sorted(left + right)): a * b})
        return product

    def __neg__(self) -> "Polynomial":
        """Negative of the polynomial."""
        return self * -1.0

    def __sub__(self, other: Scalar) -> "Polynomial":
        """Difference with a polynomial or a number."""
        return self + Polynomial.of(other) * -1.0

    def __rsub__(self, other: Scalar) -> "Polynomial":
        """Difference of a number and this."""
        return -self + other

    __radd__ = __add__
    __rmul__ = __mul__


def linear_text(coefficients: Mapping[str, Scalar]) -> str:
    """Write a sum of parameters as (12) prints it: "IA1 + D3^2*(M3+M4) + YY2".

    Parameters with the same factor share a bracket; factors are in alphabetical order, and terms in the order
    of their last factors.
    """
    single = sorted(
        (monomial, float(f"{factor:.9g}"), name)
        for name, value in coefficients.items()
        for monomial, factor in Polynomial.of(value).terms.items()
        if abs(factor) > _ROUNDING
    )
    terms = []
    for (monomial, factor), group in groupby(single, key=lambda term: term[:2]):
        names = [name for _, _, name in group]
        plain = not monomial and abs(factor) == 1.0
        terms += [(monomial, factor, [name]) for name in names] if plain else [(monomial, factor, names)]
    terms.sort(key=lambda term: _factors(term[0], term[2][0])[::-1])
    text = "".join(_term(*term) for term in terms)
    return ("-" if text.startswith(" -") else "") + text[3:]


def _factors(monomial: Monomial, parameter: str) -> list[tuple[str, int]]:
    powers = [(name, monomial.count(name)) for name in dict.fromkeys(monomial)]
    return sorted([*powers, (parameter, 1)])


def _term(monomial: Monomial, factor: float, names: list[str]) -> str:
    size = [] if abs(factor) == 1.0 else [f"{abs(factor):.6g}"]
    bracket = names[0] if len(names) == 1 else f"({'+'.join(names)})"
    written = [
        bracket if name == names[0] else name if power == 1 else f"{name}^{power}"
        for name, power in _factors(monomial, names[0])
    ]
    return f" {'-' if factor < 0 else '+'} {'*'.join(size + written)}"
