"""``dynident design``, ``near`` and ``score``: what is asked for arrives, what is written, and how it is judged."""

from pathlib import Path

import pytest
from dynident.tests.commands.typed import answered, refused, typed
from dynident.tests.selection import cases

DESIGN, SCORE = "design --robot rx90", "score --robot rx90"
NOISE = "--torque-noise 24,30,10.8,5.1,6.6,2.3"


@pytest.mark.long
@pytest.mark.parametrize(
    ("goal", "shape"),
    [("--columns payload --criterion cond", "--via-points 4"), ("--criterion d", "--fourier 3 --duration 6")],
)
def test_a_designed_csv_is_judged_as_the_design_was(here: Path, goal: str, shape: str) -> None:
    designed, _ = answered(f"{DESIGN} {goal} {shape} {NOISE} --starts 1 --samples m.csv sample-rate=1000")
    judged, text = answered(f"{SCORE} {goal} {NOISE} m.csv")
    assert judged["evaluated"] == "m.csv"
    assert "motion" not in judged
    assert judged["limits"]["met"]
    # The design's own grid has 120 samples a second here: the sign of a speed switches up to 8 ms away, which the
    # condition number in SI units and joint 2's sigmas feel most. At 240, 500, 1,000 and 2,000 samples a second
    # they are .9 to 1 and .7 to .8 % from the design's.
    for key in ("condition_number", "condition_number_scaled", "log_det", "duration_s"):
        error = 1.5e-2 if key == "condition_number" else 2e-3
        assert judged[key] == pytest.approx(designed[key], rel=error), key
        assert f"{judged[key]:.4g}" in text
    assert judged["predicted_sigma"] == pytest.approx(designed["predicted_sigma"], rel=1e-2)


@pytest.mark.parametrize(
    "file", cases(("--val3 app", "--ros2 m.yaml", "--urscript m.script"), lambda file: file.startswith("--val3"))
)
def test_files_whose_controllers_break_a_limit_are_refused(here: Path, file: str) -> None:
    """Nothing is written or shown; with room left by the setting torque-margin the same file is written."""
    line = (
        "design --robot tx40 --columns payload --torque-noise 1% --via-points 4 --starts 1 --seed 2 "
        f"acceleration=5x --heaviest-payload 2@0,0,0.05 --within 0.1 --segments trapezoid {file}"
    )
    error = refused(f"{line} --json m.json")
    assert "the motion does not keep its limits (torque with any payload up to 2 kg of joint" in error
    assert not list(here.iterdir())
    status, _, err = typed(f"{line} torque-margin=30%")
    assert status == 0, err
    assert [path.name for path in here.iterdir()] == [file.split()[1]]
