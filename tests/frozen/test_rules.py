"""The comparison can fail: each kind of number is refused just beyond its tolerance, and taken just within."""

import copy
import math

import pytest
from dynident.tests.frozen.compare import differences, told
from dynident.tests.frozen.documents import CONSTRAINED, FREE, ITERATED, SCORE, UNDECIDED, ZERO
from dynident.tests.frozen.freeze import TERMINAL, Frozen, read
from dynident.tests.frozen.runs import RUNS, Run
from dynident.tests.frozen.texts import same_printed, take_apart, text_of_html

RUN = {run.name: run for run in RUNS}


def number(frozen: Frozen, path: str) -> float:
    value = frozen.documents["a.json"][path]
    assert isinstance(value, float)
    return value


def refused(run: Run, old: Frozen, path: str, step: float) -> bool:
    """Whether one number that is moved by a step is refused, and it alone."""
    new = copy.deepcopy(old)
    new.documents["a.json"][path] = number(old, path) + step
    rows = differences(run, old, new)
    assert all(row.place == path for row in rows)
    return bool(rows)


@pytest.mark.parametrize(
    ("name", "path", "of", "share"),
    [
        ("payload_rx90", "estimates/0/parameters/XX", "estimates/0/sigma/XX", FREE),
        ("payload_rx90", "estimates/0/interval95_robust/M/1", "estimates/0/sigma/M", FREE),
        ("payload_rx90", "estimates/0/com/0", "estimates/0/com_sigma/0", FREE),
        ("payload_rx90", "estimates/2/sigma/MX", "estimates/2/sigma/MX", FREE),
        ("payload_rx90", "estimates/0/min_pseudo_inertia_eigenvalue", "", FREE),
        ("payload_rx90", "relative_residual/all", "", FREE),
        ("payload_rx90", "data/condition_number", "", FREE),
        ("payload_rx90", "estimates/7/parameters/XX", "estimates/3/sigma/XX", CONSTRAINED),
        ("payload_rx90", "estimates/7/interval95/M/0", "estimates/3/sigma/M", CONSTRAINED),
        ("payload_rx90", "estimates/7/inertia_com/0/1", "estimates/3/inertia_com_sigma/0/1", CONSTRAINED),
        ("payload_rx90", "estimates/7/chi2_rise", "", CONSTRAINED),
        ("payload_rx90", "estimates/7/min_pseudo_inertia_eigenvalue", "estimates/3/parameters/M", ZERO),
        ("weigh_rx90", "quantities/mass/value", "quantities/mass/sigma", CONSTRAINED),
        ("weigh_rx90", "mass_by_joints/0/mass", "mass_by_joints/0/sigma", FREE),
        ("identify_rx90_essential", "base_parameters/3/value", "base_parameters/3/sigma", FREE),
        ("identify_rx90_essential", "constrained/base_parameters/3/free", "", FREE),
        ("identify_rx90_essential", "constrained/base_parameters/3/value", "base_parameters/3/sigma", CONSTRAINED),
        ("identify_rx90_essential", "covariance/3/3", "", FREE),
        ("identify_rx90_essential", "constrained/min_eigenvalues/2", "", UNDECIDED),
        ("gains_ur10e", "drive_gains/values/0", "drive_gains/sigma/0", ITERATED[0]),
        ("gains_ur10e", "drive_gains/relative_sigma/5", "drive_gains/relative_sigma/5", ITERATED[1]),
        ("gains_ur10e", "relative_residual/all", "", ITERATED[1]),
        ("score_rx90_stored_motion", "log_det", "", SCORE),
        ("score_rx90_stored_motion", "predicted_sigma/ZZ1", "", SCORE),
    ],
)
def test_a_number_just_beyond_its_tolerance_is_refused(name: str, path: str, of: str, share: float) -> None:
    old = read(RUN[name])
    step = share * abs(number(old, of or path))
    assert not refused(RUN[name], old, path, 0.5 * step)
    assert refused(RUN[name], old, path, 2.0 * step)
    assert refused(RUN[name], old, path, math.nan)


def test_a_worse_design_is_refused_and_a_better_one_taken() -> None:
    for name in ("design_rx90_via_points", "design_rx90_fourier", "design_rx90_near"):
        old = read(RUN[name])
        for worse, is_refused in ((1.02, False), (1.05, True), (0.5, False)):
            new = copy.deepcopy(old)
            leaves = new.documents["a.json"]
            for path, value in leaves.items():
                if path.startswith("predicted_sigma/") and isinstance(value, float):
                    leaves[path] = worse * value
                elif path == "criterion_value" and isinstance(value, float):
                    leaves[path] = value + math.log(worse)
            assert bool(differences(RUN[name], old, new)) == is_refused


def test_a_key_that_goes_or_comes_or_changes_its_kind_is_refused() -> None:
    run = RUN["payload_rx90"]
    old = read(run)
    for path, value in (("data/equations", 342), ("data/equations", None), ("verdict/level", "use"), ("new", 1.0)):
        new = copy.deepcopy(old)
        new.documents["a.json"][path] = value
        assert len(differences(run, old, new)) == 1
    new = copy.deepcopy(old)
    del new.documents["a.json"]["data/equations"]
    assert "data/equations" in told(run, differences(run, old, new))
    assert differences(run, old, old._replace(status=1))
    assert differences(run, old, old._replace(documents={}))


def test_a_changed_word_is_refused_everywhere() -> None:
    for name, run in RUN.items():
        old = read(run)
        assert not differences(run, old, old)
        for text in old.texts:
            new = copy.deepcopy(old)
            new.texts[text].words[-1] += " indeed"
            assert differences(run, old, new), (name, text)
        new = copy.deepcopy(old)
        new.texts[TERMINAL].words.reverse()
        assert len(old.texts[TERMINAL].words) == 1 or differences(run, old, new), name


@pytest.mark.parametrize(
    ("old", "new", "same"),
    [
        ("0.201", "0.202", True),
        ("0.201", "0.203", False),
        ("0.0000", "-0.0000", True),
        ("9.99", "10.0", True),
        ("54", "55", False),
        ("1.2e-05", "1.3e-05", True),
        ("1.2e-05", "1.4e-05", False),
        ("0.00950680866166655", "0.00950680866266655", True),
        ("0.00950680866166655", "0.00950681866166655", False),
        ("4.769e-18", "-1.305e-18", True),
    ],
)
def test_printed_numbers(old: str, new: str, same: bool) -> None:
    assert same_printed(old, new) == same


def test_numbers_are_cut_and_names_are_kept() -> None:
    text = take_apart("XX3R of rx90: 0.20±0.02 kg m², joints 1-3,\n\n  dynident 0.1.0 at 1970-01-01 00:00")
    assert text.words == ["XX3R of rx90: #±# kg m², joints #-#,", "dynident @ at @"]
    assert text.numbers == ["0.20", "0.02", "1", "3"]
    page = "<style>a 1</style><p>mass <b>6</b> kg</p><svg><title>no</title><text>7</text></svg><p>end"
    assert take_apart(text_of_html(page)) == (["mass # kg", "end"], ["6"])


def test_a_report_of_differences_is_short() -> None:
    run = RUN["payload_rx90"]
    old = read(run)
    new = copy.deepcopy(old)
    for path, value in old.documents["a.json"].items():
        if isinstance(value, float):
            new.documents["a.json"][path] = 2.0 * value + 1.0
    lines = told(run, differences(run, old, new)).splitlines()
    assert len(lines) == 23
    assert "freeze payload_rx90" in lines[-1]
