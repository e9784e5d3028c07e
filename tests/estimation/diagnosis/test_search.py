"""How much a wrong assumption must explain to be told: both sides of each threshold, from made suspects."""

from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import pytest
from dynident.estimation.diagnosis import search
from dynident.estimation.diagnosis.search import AS_GOOD, CONVINCING, HELPFUL, NOTABLE, SETTLED, Cause
from dynident.estimation.diagnosis.suspects import FAMILIES, Suspect
from dynident.tests.estimation.diagnosis.made import ROBOT, SOURCE

Look = Callable[..., Cause | None]


@pytest.fixture
def look(monkeypatch: pytest.MonkeyPatch) -> Look:
    """``look(before, families, contradicted)``: the cause told of a recording, families of misfits left by name."""

    def cause(before: float, families: list[dict[str, float]], contradicted: bool = False) -> Cause | None:
        def family(misfits: dict[str, float]) -> Callable[[Any], Iterator[Suspect]]:
            return lambda _: (Suspect(words, misfit) for words, misfit in misfits.items())

        def model(_: Any, sample: Any, apart: bool) -> Any:
            return SimpleNamespace(sample=sample, misfit=lambda: sample.misfit)

        monkeypatch.setattr(search, "FAMILIES", tuple(map(family, families)))
        monkeypatch.setattr(search, "Model", SimpleNamespace(of=model))
        samples: list[Any] = [
            SimpleNamespace(source=name, t=(0.0, 1.0), misfit=misfit)
            for name, misfit in (("A", 0.0), ("B", before))
        ]
        return search.likely_cause(ROBOT, samples, contradicted)

    return cause


@pytest.mark.parametrize(("contradicted", "enough"), [(False, CONVINCING), (True, HELPFUL)])
def test_a_cause_must_help_enough(look: Look, contradicted: bool, enough: float) -> None:
    """By less where the recordings contradict the model anyway; the recording that fits worst is looked at."""
    assert look(0.5, [{"late": 1.001 * enough * 0.5}], contradicted) is None
    assert look(0.5, [{"late": 0.999 * enough * 0.5}], contradicted) == Cause(
        "B", "late", 0.5, 0.999 * enough * 0.5
    )


def test_a_fall_must_be_notable(look: Look) -> None:
    """A fifth of a small misfit is nothing."""
    assert look(0.01, [{"late": 0.01 - 0.999 * NOTABLE}]) is None
    assert look(0.01, [{"late": 0.01 - 1.001 * NOTABLE}]) is not None


def test_what_cannot_be_told_apart_is_told_together(look: Look) -> None:
    """The first of three at most; the misfit is that of the first."""
    left = {"one": 0.999 * AS_GOOD * 0.2, "two": 0.2, "three": 1.001 * AS_GOOD * 0.2}
    cause = look(0.5, [left])
    assert cause is not None
    assert (cause.words, cause.after) == ("one, or two", left["one"])
    cause = look(0.5, [dict.fromkeys("abcd", 0.2)])
    assert cause is not None
    assert cause.words == "a, or b, or c"


def test_a_settled_case_is_not_looked_at_again(look: Look) -> None:
    """Families after one that explains nearly all are not tried."""
    for share, words in ((1.001, "better"), (0.999, "first")):
        cause = look(0.5, [{"first": share * SETTLED * 0.5}, {"better": 0.1}])
        assert cause is not None
        assert cause.words == words


def test_the_worst_kind_comes_first_and_the_same_words_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """One cause each for recordings without and with payload."""
    causes = iter([Cause("U", "late", 0.5, 0.4), Cause("L", "turned", 0.5, 0.1)])
    monkeypatch.setattr(search, "likely_cause", lambda *_: next(causes))
    assert [cause.source for cause in search.likely_causes(ROBOT, SOURCE)] == ["L", "U"]
    causes = iter([Cause("U", "late", 0.5, 0.4), Cause("L", "late", 0.5, 0.1)])
    assert [cause.source for cause in search.likely_causes(ROBOT, SOURCE)] == ["L"]


def test_every_family_is_in_the_table_once() -> None:
    names = [family.__name__ for family in FAMILIES]
    assert len(set(names)) == len(names) == 15
