"""Names in figures are text, whatever they hold."""

import pytest
from dynident.apps.report.figures.canvas import log_scale, new_figure, svg_text


@pytest.mark.parametrize("name", ["a $x_$ b", "$\\frac$", "[/x]", "50 % _of_ ^it^", "<b>&amp;"])
def test_a_name_is_no_formula(name: str) -> None:
    figure = new_figure(4.0, 3.0)
    axis = figure.add_subplot()
    axis.plot([1, 2], [1e-3, 1e3], label=name)
    axis.set_title(name)
    axis.set_xticks([1, 2], [name, "other"])
    axis.legend()
    log_scale(axis)
    drawn = svg_text(figure, "names")
    escaped = name.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    assert drawn.count(f">{escaped}</text>") == 3, "title, legend and tick"
    assert "<tspan" not in drawn
    assert ">0.001</text>" in drawn, "powers of ten are plain numbers"
