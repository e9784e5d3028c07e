"""How much a wrong assumption must explain to be told: both sides of each threshold, from made comparisons."""

from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from dynident.estimation.diagnosis import causes
from dynident.estimation.diagnosis.causes import AS_GOOD, CAUSE_Z, CONVINCING, FAMILIES, SERIOUS, SETTLED
from dynident.estimation.diagnosis.evidence import Alternative
from dynident.estimation.diagnosis.finding import Finding
from dynident.estimation.diagnosis.hypotheses import HELPFUL
from dynident.tests.estimation.diagnosis.made import ROBOT

Search = Callable[..., list[Finding]]


class Everything(SimpleNamespace):
    """States of one recording, whatever is asked of them."""

    def taken(self, _: Any) -> "Everything":
        return self

    def mixed(self, changed: Any, _: Any) -> Any:
        return changed


@pytest.fixture
def search(monkeypatch: pytest.MonkeyPatch) -> Search:
    """``search(families, ...)``: what is told of families of assumptions, each by its fall of chi2, z, and part."""

    def told(families: list[dict[str, float]], contradicted: bool = False, z: float = 9.0, part: str = "") -> Any:
        def family(falls: dict[str, float]) -> tuple[Callable[..., Iterator[Any]], bool]:
            return lambda *_: ((text, None, fall) for text, fall in falls.items()), True

        def compared(_: str, text: str, __: Any, fall: float, worth: float) -> Alternative | None:
            return Alternative("", text, fall, z) if fall > worth else None

        monkeypatch.setattr(causes, "FAMILIES", tuple(map(family, families)))
        own = SimpleNamespace(compared=compared, states=Everything())
        monkeypatch.setattr(causes.Comparison, "of", lambda *_: own)
        monkeypatch.setattr(causes, "_parts", lambda _: [(part, np.ones(9, dtype=bool))])
        states: Any = Everything(t=np.zeros(9))
        return causes.likely_causes(ROBOT, states, contradicted)

    return told


@pytest.mark.parametrize(("contradicted", "enough"), [(False, CONVINCING), (True, HELPFUL)])
def test_a_cause_must_help_enough(search: Search, contradicted: bool, enough: float) -> None:
    """By less where the recordings contradict the model anyway."""
    assert not search([{"late": 0.999 * enough}], contradicted)
    (finding,) = search([{"late": 1.001 * enough}], contradicted)
    assert finding.text.startswith("the recordings look as if late")
    assert finding.explains == 1.001 * enough


def test_a_fall_must_be_more_than_chance(search: Search) -> None:
    assert not search([{"late": 0.5}], z=0.999 * CAUSE_Z)
    assert search([{"late": 0.5}], z=1.001 * CAUSE_Z)


def test_what_cannot_be_told_apart_is_told_together(search: Search) -> None:
    """The first of three at most; the fall is that of the first."""
    falls = {"one": 1.0 - 0.999 * AS_GOOD * 0.5, "two": 0.5, "three": 1.0 - 1.001 * AS_GOOD * 0.5}
    (finding,) = search([falls])
    assert "as if two, or one:" in finding.text
    (finding,) = search([dict.fromkeys("abcd", 0.5)])
    assert "as if a, or b, or c:" in finding.text


def test_a_settled_case_is_not_looked_at_again(search: Search) -> None:
    """Families after one that explains nearly all are not tried."""
    for share, text in ((1.001, "better"), (0.999, "first")):
        (finding,) = search([{"first": 1.0 - share * SETTLED}, {"better": 0.999}])
        assert f"as if {text}:" in finding.text


def test_a_cause_in_some_recordings_is_serious_where_it_explains_half(search: Search) -> None:
    for fall, part, severity in (
        (0.999, "L", "warning"),
        (1.001, "L", "error"),
        (0.999, "", "error"),
    ):
        (finding,) = search([{"late": fall * SERIOUS}], part=part)
        assert (finding.severity, finding.about, finding.cause) == (severity, part or "everything", True)


def test_every_family_is_in_the_table_once() -> None:
    names = [family.__name__ for family, _ in FAMILIES]
    assert len(set(names)) == len(names) == 8
