"""``dynident export``: which estimate, which frame, and what it refuses."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dynident.apps.export.controllers import FORMATS
from dynident.cli import main
from dynident.model import InertialParameters, load_robot, robot_names
from dynident.model.inertia import ten_parameters
from dynident.tests.report.controllers.parsers import PARSERS
from scipy.spatial.transform import Rotation

Run = Callable[..., tuple[int, str, str]]
BODY = InertialParameters.from_com(3.0, [0.02, 0.05, 0.11], np.diag([0.02, 0.03, 0.025]) + 0.002 * np.ones((3, 3)))
IMPOSSIBLE = InertialParameters(ten_parameters(3.1, np.array([0.02, 0.05, 0.11]), np.diag([0.01, 0.01, 0.05])))


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    def runner(*arguments: str) -> tuple[int, str, str]:
        try:
            status = main(["export", *arguments])
        except SystemExit as stop:
            status = int(stop.code or 0)
        captured = capsys.readouterr()
        return status, captured.out, captured.err

    return runner


def estimate(method: int, mass: float, estimator: str = "wls", body: InertialParameters = BODY) -> dict[str, Any]:
    heavier = InertialParameters(ten_parameters(mass, body.com, body.inertia_com))
    return {"method": method, "estimator": estimator, "parameters": heavier.named()}


@pytest.fixture
def payload(tmp_path: Path) -> Callable[..., str]:
    def write(*estimates: dict[str, Any], **more: Any) -> str:
        document = {
            "frame": "tool0: the bare flange, z out of it",
            "estimates": estimates or [estimate(4, 3.0)],
            "verdict": {"level": "use", "reasons": []},
        }
        path = tmp_path / "payload.json"
        path.write_text(json.dumps(document | more), encoding="utf-8")
        return str(path)

    return write


@pytest.mark.parametrize("name", FORMATS)
def test_every_format(run: Run, payload: Callable[..., str], tmp_path: Path, name: str) -> None:
    target = tmp_path / "load.txt"
    status, out, err = run(payload(), "--to", name, "--out", str(target))
    assert (status, out) == (0, "")
    text = target.read_text(encoding="utf-8")
    assert PARSERS[name](text).mass == pytest.approx(3.0)
    assert "payload.json, method 4 (wls)" in text
    assert err == ""
    status, out, _ = run(payload(), "--to", name)
    assert (status, out) == (0, text)


@pytest.mark.parametrize(
    ("methods", "options", "mass"),
    [
        ((1, 2, 3, 4), (), 3.0),
        ((1, 2, 4), (), 4.0),
        ((1, 2, 3), (), 3.0),
        ((1, 2), (), 1.0),
        ((2,), (), 2.0),
        ((1, 2), ("--method", "2"), 2.0),
    ],
)
def test_which_method(
    run: Run, payload: Callable[..., str], methods: tuple[int, ...], options: tuple[str, ...], mass: float
) -> None:
    _, out, err = run(payload(*(estimate(m, float(m)) for m in methods)), "--to", "ur", *options)
    assert PARSERS["ur"](out).mass == mass, err
    assert f"method {mass:.0f} (wls)" in out


def test_the_recommended_method_comes_first_unless_another_is_asked_for(
    run: Run, payload: Callable[..., str]
) -> None:
    estimates = [estimate(m, float(m), kind) for m in (1, 3, 4) for kind in ("wls", "constrained")]
    path = payload(*estimates, recommended={"method": 3, "estimator": "constrained"})
    assert "method 3 (constrained)" in run(path, "--to", "ur")[1]
    assert "method 1 (constrained)" in run(path, "--to", "ur", "--method", "1")[1]
    status, _, err = run(payload(*estimates, recommended=[4]), "--to", "ur")
    assert status == 2
    assert "key 'recommended': must be a table, got [4]: give the --json of 'dynident payload'" in err


def test_mass_and_com_only_leaves_the_inertia_out(run: Run, payload: Callable[..., str]) -> None:
    """Then even an inertia that cannot exist does no harm; it is not written."""
    verdict = {"level": "mass_and_com_only", "reasons": ["no body has the inertia that method 4 gives"]}
    path = payload(estimate(4, 3.1, body=IMPOSSIBLE), verdict=verdict)
    status, out, _ = run(path, "--to", "ur")
    assert status == 0
    assert not PARSERS["ur"](out).inertia.any()
    assert "mass and com only" in out
    assert "no body has the inertia" in out
    status, _, err = run(path, "--to", "ur", "--despite-verdict")
    assert status == 2
    assert "no body has this inertia" in err
    possible = payload(verdict=verdict)
    _, out, _ = run(possible, "--to", "ur", "--despite-verdict")
    np.testing.assert_allclose(PARSERS["ur"](out).inertia, BODY.inertia_com, atol=1e-9)


def test_do_not_use_is_not_written(run: Run, payload: Callable[..., str], tmp_path: Path) -> None:
    target = tmp_path / "load.txt"
    path = payload(verdict={"level": "do_not_use", "reasons": ["masses spread"]})
    status, out, err = run(path, "--to", "ur", "--out", str(target))
    assert (status, out) == (1, "")
    assert not target.exists()
    assert "masses spread" in err
    status, out, _ = run(path, "--to", "ur", "--despite-verdict")
    assert status == 0
    assert "Verdict: do not use" in out


def test_what_the_arm_does_not_carry_needs_the_word(run: Run, payload: Callable[..., str], tmp_path: Path) -> None:
    """A mass beyond the rated payload, an estimate's error allowed; on both sides of it, and for every format."""
    target = tmp_path / "load"
    for name in FORMATS:
        status, out, err = run(payload(rated_payload_kg=2.8), "--to", name, "--out", str(target))
        assert (status, out) == (1, "")
        assert "a mass of 3 kg, the arm carries 2.8 kg; --despite-verdict writes it all the same" in err
        assert not target.exists()
        assert run(payload(rated_payload_kg=2.8), "--to", name, "--despite-verdict")[0] == 0
        for rated in (2.86, 12.5, None):
            assert run(payload(rated_payload_kg=rated), "--to", name)[0] == 0


@pytest.mark.parametrize(
    ("kind", "value", "words"),
    [
        ("M", 1e308, "nothing that an arm carries"),
        ("M", 1e5, "nothing that an arm carries"),
        ("MX", 1e308, "nothing that an arm carries"),
        ("MX", 40.0, "nothing that an arm carries"),
        ("XX", 1e308, "are nothing that"),
        ("XX", "0.1", "finite number"),
        ("M", "3", "finite number"),
        ("M", True, "finite number"),
    ],
)
def test_numbers_that_no_arm_carries_are_refused(
    run: Run, payload: Callable[..., str], kind: str, value: Any, words: str
) -> None:
    """Whatever is said of the verdict; text in the place of a number is told by its key."""
    entry = estimate(4, 3.0)
    entry["parameters"][kind] = value
    for word in ((), ("--despite-verdict",)):
        status, out, err = run(payload(entry), "--to", "ur", *word)
        assert (status, out) == (2, "")
        assert words in err
        assert len(err.splitlines()) == 1


def test_a_payload_frame_that_is_not_the_flange(run: Run, payload: Callable[..., str]) -> None:
    """Frame 6 of the RX90 is at the wrist: its flange must be told, here 85 mm out and a quarter turn about z."""
    path = payload(frame="frame 6 (modified DH): origin at the wrist centre, z along axis 6; not the flange")
    status, _, err = run(path, "--to", "ur")
    assert status == 2
    assert "give --flange-frame" in err
    _, out, _ = run(path, "--to", "ur", "--flange-frame", "0", "0", "0.085", "0", "0", "90")
    parsed = PARSERS["ur"](out)
    np.testing.assert_allclose(parsed.com, [0.05, -0.02, 0.11 - 0.085], atol=1e-9)
    turn = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(parsed.inertia, turn @ BODY.inertia_com @ turn.T, atol=1e-9)
    assert "(0, 0, 0.085) m, (0, 0, 90) deg" in out


def test_grip_load_of_abb_in_the_tool_frame(run: Run, payload: Callable[..., str]) -> None:
    pose = ["0.01", "-0.02", "0.15", "20", "-35", "130"]
    _, out, _ = run(payload(), "--to", "abb", "--tool-frame", *pose)
    R = Rotation.from_euler("ZYX", [130, -35, 20], degrees=True).as_matrix()
    parsed = PARSERS["abb"](out)
    np.testing.assert_allclose(R @ parsed.com + [0.01, -0.02, 0.15], BODY.com, atol=1e-9)
    np.testing.assert_allclose(R @ parsed.inertia @ R.T, BODY.inertia_com, atol=1e-9)
    assert "payload_grip" in out
    assert "payload_tool" in run(payload(), "--to", "abb")[1]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--to", "kuka", "--tool-frame", "0", "0", "0", "0", "0", "0"), "--tool-frame belongs to --to abb"),
        (("--to", "ur", "--meters-per-unit", "1"), "--meters-per-unit belongs to --to usd"),
        (("--to", "usd", "--meters-per-unit", "0"), "must be positive"),
        (("--to", "usd", "--meters-per-unit", "nan"), "not a number"),
        (("--to", "ur", "--flange-frame", "0", "0", "nan", "0", "0", "0"), "--flange-frame: 'nan' is not a number"),
        (("--to", "ur", "--flange-frame", "1e300", "0", "0", "0", "0", "0"), "--flange-frame"),
        (("--to", "abb", "--tool-frame", "0", "1e9", "0", "0", "0", "0"), "--tool-frame"),
        (("--to", "siemens"), 'Invalid value "siemens" for --to'),
        (("--to", "ur", "--out", "/nowhere/at/all"), "not a file in a folder"),
    ],
)
def test_wrong_options(run: Run, payload: Callable[..., str], arguments: tuple[str, ...], words: str) -> None:
    status, out, err = run(payload(), *arguments)
    assert (status, out) == (2, "")
    assert words in err


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "cannot be read as JSON"),
        ("[]", "must be a table, got []: give the --json of 'dynident payload'"),
        ('{"verdict": 3}', "key 'verdict': must be a table, got 3: give the --json of"),
        ('{"frame": "tool0", "verdict": {"level": "use", "reasons": []}, "estimates": []}', "there are none"),
    ],
)
def test_wrong_files(run: Run, tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "p.json"
    path.write_text(text, encoding="utf-8")
    status, _, err = run(str(path), "--to", "ur")
    assert status == 2
    assert words in err
    assert run(str(tmp_path / "none.json"), "--to", "ur")[0] == 2


@pytest.mark.parametrize("name", robot_names())
def test_shipped_robots_name_their_flange(run: Run, payload: Callable[..., str], name: str) -> None:
    """Frame 6 at the wrist centre is not the flange; the flanges of all other shipped robots are known as such."""
    frame = load_robot(name).payload_frame
    status, _, _ = run(payload(frame=frame), "--to", "ur")
    assert status == (2 if frame.startswith("frame 6") else 0), frame
