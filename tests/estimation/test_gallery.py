"""A gallery of wrong inputs: each ends in an error or in a verdict that names the cause."""

import re
from collections.abc import Callable
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from dynident.benchmarks import invented
from dynident.benchmarks.coverage import good
from dynident.common.arrays import Array
from dynident.estimation import identify
from dynident.tests.estimation import gallery, mistakes
from dynident.tests.selection import every

CASES = {case.name: case for case in gallery.cases()}
_UNSEEN = {("rx90", 1), ("tx40", 1), ("tx40", 4), ("ur10e", 6)}
"""Joints whose sense the recordings without payload hardly show: chi2 falls by 3 % at most."""


@pytest.mark.long
def test_the_gallery_is_large_and_its_good_recordings_are_good() -> None:
    """The cases are made from recordings which, as they are, give the mass and no contradiction."""
    assert len(CASES) >= 45
    for name in ("rx90", "ur10e", "tx40"):
        good = gallery.both(name, "as it is", "", mistakes.same)
        end = gallery.ending(good)
        assert end.level in ("use", "mass_and_com_only"), end.text
        assert "joint" not in end.text
        assert "looks as if" not in end.text
        assert abs(end.mass / good.mass - 1.0) < 0.03


@pytest.mark.parametrize("name", every(16, CASES))
def test_a_wrong_input_ends_in_words_that_name_its_cause(name: str) -> None:
    case = CASES[name]
    end = gallery.ending(case)
    assert re.search(case.words, end.text), end.text
    assert end.level != "use"
    if end.level == "mass_and_com_only":
        assert abs(end.mass / case.mass - 1.0) < 0.03


@pytest.mark.parametrize(
    "turned", every(9, product(invented.NAMES, range(1, 7))), ids=lambda turned: "-".join(map(str, turned))
)
def test_a_joint_counted_the_other_way_is_named_first(turned: tuple[str, int]) -> None:
    """By the payload, and by the robot's parameters wherever the recording without payload tells it.

    Turned joints whose motion leaves the other parameters free to follow (joint 1, and some of a wrist) are not
    seen without payload; where they are, no other robot is named.
    """
    name, joint = turned
    case = gallery.both(name, "", "", mistakes.counted_backwards(joint))
    end = gallery.ending(case)
    words = f"joint {joint} is counted the other way"
    if end.level == "error":  # a joint whose range is not the same to both sides
        assert f"outside the range of joint {joint}" in end.text
        return
    assert end.level == "do_not_use"
    assert words in end.text.split(" | ")[0]
    reasons = identify(case.robot, case.unloaded).verdict.reasons
    assert bool(reasons) == (turned not in _UNSEEN)
    assert all(re.search(f"joint (. or )?{joint}( or .)? is counted the other way", text) for text in reasons[:1])
    assert not any("of robot" in text for text in reasons)


@pytest.mark.parametrize(
    ("level", "words", "spoil"),
    [
        ("read", "time is in ms", lambda t: 1000.0 * t),
        ("read", "repeat the time of the row before", lambda t: np.repeat(t[::2], 2)[: len(t)]),
        ("error", "runs back", lambda t: t[::-1]),
        ("error", "stands still", lambda t: np.full(len(t), t[0])),
    ],
)
def test_wrong_columns_of_time_are_told(
    tmp_path: Path, level: str, words: str, spoil: Callable[[Array], Array]
) -> None:
    end = gallery.reading(tmp_path / "log.csv", spoil)
    assert end.level == level
    assert words in end.text


@pytest.mark.parametrize("seed", every(5, range(20, 30)))
def test_good_recordings_are_answered_as_far_as_they_determine(seed: int) -> None:
    """Ten of the benchmark's two hundred; more would take too long here."""
    *_, stated = good("", seed)
    assert stated.held.all(), stated.text
    assert abs(stated.more["worst mass error %"]) < 0.06
