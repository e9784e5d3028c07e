"""``dynident design`` on the command line: bad requests in one line, limits that cannot be met, Ctrl-C."""

from pathlib import Path
from typing import Any

import pytest
from dynident.tests.commands.runs import QUICK, Run, document, runner
from dynident.trajectories import DesignProblem


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    return runner(capsys, "design", "--robot", "rx90")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--ramp", "0.2"), "--ramp has no effect without --segments trapezoid"),
        (("--segments", "trapezoid", "--ramp", "0.7"), "a ramp of 0.7 of a move's time"),
        (("--fourier", "3", "--ramp", "0"), "--ramp belongs to --via-points"),
        (("--fourier", "3", "--segments", "quintic"), "--segments belongs to --via-points"),
        (("--segment-durations", "1,2"), "fixed durations 1, 2: 14 via points need 13"),
        (("--segment-durations", "1", "--max-duration", "20"), "leave --max-duration out"),
    ],
)
def test_segments_that_cannot_be(run: Run, options: tuple[str, ...], words: str) -> None:
    status, out, err = run("--torque-noise", "1,1,1,1,1,1", *options)
    assert (status, out) == (2, "")
    assert words in err
    assert len(err.splitlines()) == 1


@pytest.mark.long
def test_limits_that_cannot_be_met_are_told_in_one_line(run: Run, tmp_path: Path) -> None:
    target = tmp_path / "m.csv"
    status, out, err = run(
        "--columns", "ZZ1,FV1,FS1,XX2,MX2,FV2,FS2", "--fourier", "2", "--duration", "4", "--starts", "1",
        "--torque-limits", "300,20,120,50,40,20", "--torque-noise", "1,1,1,1,1,1", "--samples", str(target),
    )  # fmt: skip
    assert status == 2
    assert err.count("\n") == 1
    assert "no motion was found that keeps every limit" in err
    assert "torque of joint 2" in err
    assert "violated by" in err
    assert out == ""
    assert not target.exists()


def test_ctrl_c_keeps_the_best_motion(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    calls, true = [0], DesignProblem.evaluate

    def evaluate(self: DesignProblem, *arguments: Any, **named: Any) -> Any:
        calls[0] += 1
        if calls[0] == 60:
            raise KeyboardInterrupt
        return true(self, *arguments, **named)

    monkeypatch.setattr(DesignProblem, "evaluate", evaluate)
    target = tmp_path / "m.json"
    status, _, err = run(
        *QUICK, "--torque-noise", "1,1,1,1,1,1", "--json", str(target), "--samples", str(tmp_path / "m.csv")
    )
    assert status == 0
    assert "interrupted: this is the best motion so far; it keeps every limit" in err
    data = document(target)
    assert data["interrupted"]
    assert data["limits"]["met"]
    assert "interrupted" in (tmp_path / "m.csv").read_text().split("\n")[2]


@pytest.mark.long
def test_ctrl_c_while_the_floor_is_sought(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def stopped(*_: Any, **__: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("dynident.trajectories.floor_under", stopped)
    target = tmp_path / "m.json"
    options = ("--torque-noise", "1,1,1,1,1,1", "--json", str(target), "--samples", str(tmp_path / "m.csv"))
    status, _, err = run(*QUICK, *options, "--bound")
    assert status == 0
    assert "interrupted: the floor is not known" in err
    assert document(target)["floor"] is None
    assert (tmp_path / "m.csv").exists()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--criterion", "e"), 'Invalid value "e" for --criterion'),
        (("--columns", "payload", "--parameters", "M"), "cannot design for these parameters of robot 'rx90': M"),
        (("--via-points", "5", "--fourier", "3"), "give one of them"),
        (("--via-points", "2"), "at least 3"),
        (("--fourier", "1"), "give at least 2"),
        (("--fourier", "500"), "at most 50"),
        (("--fourier", "3", "--duration", "1e6"), "in up to 3600 s"),
        (("--via-points", "1000000"), "give 2 to 500"),
        (("--via-points", "1000000", "--segment-durations", "1"), "give 2 to 500"),
        (("--segment-durations", "1e9"), "need 13 positive ones"),
        (("--duration", "5"), "via points take --max-duration"),
        (("--fourier", "3", "--max-duration", "5"), "--fourier takes --duration"),
        (("--fourier", "3", "--rest"), "--rest belongs to --via-points"),
        (("--fourier", "3", "--val3", "x"), "Fourier motion has none"),
        (("--duration", "-1"), "not a number above 0"),
        (("--speed-override", "1.5"), "speed override is 1.5"),
        (("--acceleration", "0x"), "not a factor such as 3x"),
        (("--acceleration", "1,2"), "2 numbers for the 6 joints"),
        (("--torque-limits", "1,2"), "2 numbers for the 6 joints of robot 'rx90'"),
        (("--torque-noise", "10%", "--torque-limits", "none"), "needs a torque limit of every joint"),
        (("--torque-noise", "1,2"), "needs 6 positive numbers"),
        (("--start", "1,2,3"), "3 numbers for the 6 joints"),
        (("--start", "0,0,0,0,121,0"), "joint 5 at 121 deg is outside -105 to 120 deg"),
        (("--parameters", "XX9"), "XX9"),
        (("--parameters", "FV1,FV1"), "not a list of different names"),
        (("--columns", "XX1,ZZ1"), "XX1 has no effect"),
        (("--criterion", "cond", "--parameters", "FV1"), "counts for d and a only"),
        (("--columns", "payload", "--criterion", "a"), "needs reference values"),
        (("--heaviest-payload", "7", "--torque-limits", "none"), "give --torque-limits"),
        (("--heaviest-payload", "heavy", "--torque-limits", "1,1,1,1,1,1"), "give kg, kg@x,y,z (m), or a TOML"),
        (("--within", "0.1"), "--within needs --heaviest-payload"),
        (("--heaviest-payload", "7", "--within", "0"), "each above 0 m"),
        (("--heaviest-payload", "7", "--within", "box:1,2"), "is not R, A,B,C or box:A,B,C"),
        (("--heaviest-payload", "x.toml", "--within", "0.1"), "x.toml is one"),
        (
            ("--heaviest-payload", "7", "--within", "0.1", "--torque-limits", "none"),
            "a torque limit of every joint",
        ),
        (("--torque-margin", "100%"), "'100%' is not a share"),
        (("--torque-margin", "10%", "--torque-limits", "none"), "no effect without torque limits"),
        (("--scene", "nowhere.toml"), "no such file"),
        (("--robot-parameters", "nowhere.json"), "no such file"),
        (("--data-from", "nowhere.npz"), "needs --data-length"),
        (("--data-from", "nowhere.npz", "--data-length", "9"), "no such file"),
        (("--joint-names", "a,b"), "no effect without --ros2"),
        (("--joint-names", "a,b", "--ros2", "x.yaml"), "6 different names"),
        (("--sample-rate", "100"), "no effect without --samples or --ros2"),
        (("--urscript", "x", "--controller-rate", "250"), "500 Hz (e-Series) or 125 Hz"),
        (("--val3", "no-name"), "VAL3 application's name"),
        (("--samples", "nowhere/x.csv"), "not a file in a folder that exists"),
        (("--ros2", "nowhere/x.yaml"), "not a file in a folder that exists"),
        (("--starts", "0"), "from 1 to"),
    ],
)
def test_bad_requests(
    run: Run, options: tuple[str, ...], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One line that says what is wrong, nothing written."""
    monkeypatch.chdir(tmp_path)
    status, out, err = run(*options)
    assert status == 2
    errors = [line for line in err.splitlines() if not line.startswith("dynident: note:")]
    assert len(errors) == 1
    assert words in errors[0]
    assert out == ""
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("nowhere.csv",), "no such file"),
        (("nowhere.csv", "--samples", "x.csv"), "Unknown option: --samples"),
        (("nowhere.csv", "--segments", "trapezoid"), "Unknown option: --segments"),
        (("nowhere.csv", "--starts", "3"), "Unknown option: --starts"),
        (("nowhere.csv", "--seed", "3"), "--seed has no effect without --bound"),
        (("nowhere.csv", "--data-from", "nowhere.npz"), "needs --data-length"),
        ((), "give --data"),
    ],
)
def test_bad_requests_of_score(
    options: tuple[str, ...], words: str, capsys: pytest.CaptureFixture[str], tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    status, out, err = runner(capsys, "score", "--robot", "rx90")(*options)
    assert (status, out) == (2, "")
    errors = [line for line in err.splitlines() if not line.startswith("dynident: note:")]
    assert len(errors) == 1
    assert words in errors[0]
    assert list(tmp_path.iterdir()) == []
