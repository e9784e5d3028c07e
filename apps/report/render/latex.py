"""Tables as LaTeX, for a paper: ``tabular`` with the rules of the booktabs package, the title as caption."""

import re
from collections.abc import Sequence

from ..blocks import Table

_SPECIAL = {
    "\\": r"\textbackslash{}", "{": r"\{", "}": r"\}", "_": r"\_", "%": r"\%", "&": r"\&", "#": r"\#", "$": r"\$",
    "^": r"\textasciicircum{}", "~": r"\textasciitilde{}", "<": r"$<$", ">": r"$>$", "±": r"$\pm$", "²": r"$^2$",
    "³": r"$^3$", "·": r"$\cdot$", "°": r"$^\circ$", "−": "$-$", "–": "--", "—": "---", "…": r"\dots{}",
    "χ": r"$\chi$", "σ": r"$\sigma$", "≤": r"$\leq$", "≥": r"$\geq$", "√": r"$\surd$", "Δ": r"$\Delta$",
}  # fmt: skip
_NUMBER = r"-?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?"
_HEAD = "% needs \\usepackage{booktabs}\n"


def latex_tables(tables: Sequence[Table]) -> str:
    """All tables, one ``table`` environment each."""
    return _HEAD + "\n".join(map(_table, tables))


def _table(table: Table) -> str:
    columns = "".join("r" if column.numeric else "l" for column in table.columns)
    lines = [
        r"\begin{table}",
        rf"  \caption{{{escaped(table.title)}}}",
        rf"  \begin{{tabular}}{{{columns}}}",
        r"    \toprule",
        f"    {_row([column.heading for column in table.columns])}",
    ]
    for section in table.sections:
        lines += [r"    \midrule", *(f"    {_row([str(cell) for cell in row])}" for row in section)]
    return "\n".join([*lines, r"    \bottomrule", r"  \end{tabular}", r"\end{table}"]) + "\n"


def _row(cells: Sequence[str]) -> str:
    return " & ".join(map(_cell, cells)) + r" \\"


def _cell(cell: str) -> str:
    """A number, or one with its spread, in mathematics, so that minus is a minus; else text."""
    if re.fullmatch(rf"{_NUMBER}(?:±{_NUMBER})?", cell):
        mathematics = re.sub(r"e([-+]?\d+)", lambda power: rf"\cdot 10^{{{int(power[1])}}}", cell)
        return "$" + mathematics.replace("±", r" \pm ") + "$"
    return escaped(cell)


def escaped(text: str) -> str:
    """Text that LaTeX prints as it is; letters beyond ASCII that have no command here stay (UTF-8)."""
    return "".join(_SPECIAL.get(letter, letter) for letter in text)
