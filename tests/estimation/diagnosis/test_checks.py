"""Each check of the table alone, on both sides of each of its thresholds."""

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np
import pytest
from dynident.estimation.diagnosis import checks, hypotheses, scales
from dynident.estimation.diagnosis.engine import Effect
from dynident.estimation.diagnosis.evidence import Diagnosis, Evidence
from dynident.estimation.diagnosis.finding import Finding
from dynident.estimation.diagnosis.verdict import BEFOREHAND, CHECKS, causes, judge, table
from dynident.tests.estimation.diagnosis.made import ROBOT, estimate_of, of_payload, weighed_as, with_mass
from dynident.tests.estimation.diagnosis.sides import Side, beside, hose, leaning_on
from dynident.tests.estimation.diagnosis.sides import one_cause as one_cause
from dynident.tests.estimation.diagnosis.sides_of_fits import OF_FITS
from dynident.tests.estimation.diagnosis.sides_of_guards import OF_GUARDS

SIDES = (*OF_FITS, *OF_GUARDS)
FUNCTIONS: dict[str, Callable[[Evidence], Iterable[Finding]]] = {
    check.__name__: check for check in (*CHECKS, *BEFOREHAND)
} | {"causes": lambda evidence: causes(evidence, False)}


def test_every_check_has_a_threshold_here() -> None:
    assert {side.check for side in SIDES} == set(FUNCTIONS)
    assert len(FUNCTIONS) == len(CHECKS) + len(BEFOREHAND) + 1


def test_the_table_tells_every_limit() -> None:
    rows = table()
    assert len(rows) == len(CHECKS) - 1 + len(hypotheses.HYPOTHESES) + len(BEFOREHAND)
    assert all(what and limits and "{" not in limits for what, limits in rows)


@pytest.mark.parametrize("side", SIDES, ids=[f"{side.check}: {side.words}" for side in SIDES])
def test_a_check_speaks_on_one_side_of_its_threshold(side: Side) -> None:
    """And what it says reaches the verdict."""
    near, beyond = (1.001, 0.999) if side.below else (0.999, 1.001)
    quiet, loud = side.make(near * side.limit), side.make(beyond * side.limit)

    def said(evidence: Evidence) -> list[Finding]:
        findings = list(FUNCTIONS[side.check](evidence))
        return [
            candidate
            for candidate in findings
            if candidate.severity == side.severity and side.words in candidate.text
        ]

    assert said(quiet) == []
    (finding,) = said(loud)
    verdict = judge(loud)
    assert finding in verdict.findings
    assert finding not in judge(quiet).findings
    partly = "mass_and_com_only" if loud.gained is None else "identified_only"
    assert verdict.level == {"error": "do_not_use", "warning": partly, "note": "use"}[side.severity]


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_check_is_silent_about_what_was_not_computed(name: str) -> None:
    assert list(FUNCTIONS[name](Evidence(ROBOT))) == []


def test_a_delay_or_a_pull_that_moves_the_centre_of_mass_leaves_nothing() -> None:
    for share, severity in ((0.999, "warning"), (1.001, "error")):
        moved = share * hypotheses.SLIP * 5.0 * np.array([0.6, 0.0, 0.8])
        (late,) = beside("late", 0.02).diagnosis.effects
        by_delay, by_pull = np.zeros((10, 1)), np.zeros((10, 4))
        by_delay[6:9, 0], by_pull[6:9, 0] = moved / 0.02, moved / 9.0
        for effect in (late._replace(effect=by_delay), hose(1.0)._replace(effect=by_pull)):
            (finding,) = hypotheses.hypotheses(of_payload(estimate_of(), effects=(effect,)))
            assert finding.severity == severity


def test_bursts_matter_that_move_the_mass_by_more_than_chance() -> None:
    for share, matters in ((0.999, False), (1.001, True)):
        for mass, sigma in ((5.0, 1e-3), (1e-3, 5.0 * hypotheses.MOVED / 2.0)):
            change = share * 5.0 * hypotheses.MOVED * np.eye(10)[:, 9:]
            effect = Effect("bursts", "", np.ones(1), np.zeros((1, 1)), change, size=1, sigma=20)
            assert hypotheses.matter(effect, mass, sigma) is matters
            (finding,) = hypotheses.hypotheses(of_payload(estimate_of(), effects=(effect,)))
            assert (finding.severity, "1 of 20 stretches" in finding.text) == ("note", True)


def test_a_rating_that_is_assumed_is_called_so() -> None:
    """The RX90's is; one with a source stands on its data sheet."""
    heavy = of_payload(estimate_of(ten=with_mass(20.0)))
    sheet = replace(ROBOT, sources={"rated_payload": "the maker's data sheet"})
    texts = [finding.text for robot in (ROBOT, sheet) for finding in checks.rating(replace(heavy, robot=robot))]
    assert [text.partition(" carries ")[2].partition(":")[0] for text in texts] == [
        "as is assumed",
        "by its data sheet",
    ]


def test_a_mass_that_was_weighed_a_pull_or_a_scale_that_is_seen_leaves_nothing_to_say_of_scale() -> None:
    plain = leaning_on(0.2, 1e-3)
    assert list(scales.sensitive(plain))
    (whole,) = plain.diagnosis.scales
    seen = replace(plain, diagnosis=Diagnosis(scales=(whole._replace(size=-30.0 * whole.sigma),)))
    assert list(scales.scale(seen))
    assert not list(scales.sensitive(seen))
    hung = Diagnosis(scales=plain.diagnosis.scales, effects=(hose(1.0),))
    assert not list(scales.sensitive(replace(plain, diagnosis=hung)))
    assert not list(scales.sensitive(replace(plain, constrained=(weighed_as(0.0),))))
