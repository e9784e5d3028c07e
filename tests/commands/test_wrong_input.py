"""Wrong input: one line, exit status 2, nothing written; and the command as a program."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from dynident.tests.commands.runs import Run


def bad_inputs() -> list[tuple[str, list[str], list[str]]]:
    """(name, arguments with {log} places, words that the line must hold)."""
    pair = ["--unloaded", "{bare0}", "--loaded", "{loaded0}"]
    rx90 = ["payload", "--robot", "rx90"]
    identify = ["identify", "--robot", "rx90", "--data"]
    return [
        ("unknown robot", ["payload", "--robot", "rx91", *pair], ["'rx91'", "rx90", "tx40", "ur10e"]),
        ("broken robot", ["payload", "--robot", "{broken_robot}", *pair], ["'joints[1].alpha'", "alpha_deg"]),
        ("no file", [*rx90, "--unloaded", "none.csv", "--loaded", "{loaded0}"], ["none.csv", "no such file"]),
        ("nan", [*rx90, "--unloaded", "{nan}", "--loaded", "{loaded0}"], ["nan.csv", "line 100", "'q4'"]),
        ("degrees", [*rx90, "--unloaded", "{degrees}", "--loaded", "{loaded0}"], ["degrees.csv", "degrees"]),
        ("currents", ["identify", "--robot", "rx90", "--data", "{currents}"], ["--drive-gains, 6 numbers"]),
        ("gains", ["identify", "--robot", "rx90", "--data", "{currents}", "--drive-gains", "1,2"], ["2 numbers"]),
        ("text gains", ["identify", "--robot", "rx90", "--data", "{currents}", "--drive-gains", "a"], ["'a'"]),
        ("no currents", ["identify", "--robot", "rx90", "--data", "{bare0}", "--drive-gains", "1,1,1,1,1,1"],
         ["no currents"]),
        ("short", ["identify", "--robot", "rx90", "--data", "{short}"], ["fewer samples than parameters"]),
        ("still", ["identify", "--robot", "rx90", "--data", "{still}"], ["joint 6 never moves", "FS6"]),
        ("other trajectory", [*rx90, "--unloaded", "{bare0}", "--loaded", "{loaded1}", "--method", "3"],
         ["not the same trajectory"]),
        ("dead channel", [*rx90, "--unloaded", "{dead}", "--loaded", "{loaded0}"], ["joint 4", "dead"]),
        ("milli", [*rx90, "--unloaded", "{bare0}", "--loaded", "{milli}"], ["more than a joint", "N·m"]),
        ("gap", [*identify, "{gap}"], ["20 s at most", "leave no 2 s", "record without losing rows"]),
        ("twice", [*identify, "{bare0}", "--data", "{bare0}"], ["same numbers"]),
        ("latin", [*identify, "{latin}"], ["latin.csv", "column q2", "found t, q1, Drehmoment_Größe"]),
        ("tiny equation rate", [*identify, "{bare0}", "--equation-rate", "0.001"], ["raise --equation-rate"]),
        ("tiny cutoff", [*identify, "{bare0}", "--cutoff", "1e-9"], ["raise --cutoff"]),
        ("tiny rate", [*identify, "{bare0}", "--rate", "0.01"], ["raise --rate"]),
        ("huge rate", [*identify, "{bare0}", "--rate", "1e8"], ["lower --rate"]),
        ("folder", [*identify, "."], ["not a regular file"]),
        ("dead validation", [*identify, "{bare0}", "--validate", "{dead}"], ["joint 4", "dead"]),
        ("nothing to compare", [*rx90, "--loaded", "{loaded0}"], ["--unloaded"]),
        ("method without data", [*rx90, "--loaded", "{loaded0}", "--method", "5"], ["--method"]),
        ("cutoff", [*rx90, *pair, "--cutoff", "300"], ["cut-off", "lower --cutoff"]),
        ("negative cutoff", [*rx90, *pair, "--cutoff", "-1"], ["--cutoff", "cutoff must be positive"]),
        ("equation rate", [*rx90, *pair, "--equation-rate", "0"], ["equation_rate must be positive"]),
        ("coulomb", ["payload", "--robot", "ur10e", *pair, "--coulomb", "paper"], ["no coupled drives"]),
        ("free friction", [*rx90, *pair, "--method", "3", "--free-friction"], ["--free-friction", "method 1"]),
        ("mass alone", [*rx90, *pair, "--mass", "7"], ["--mass", "such as 7+-0.01"]),
        ("negative mass", [*rx90, *pair, "--mass", "-7+-0.1"], ["--mass", "a mass above 0 kg"]),
        ("bounds", [*rx90, *pair, "--mass-bounds", "8,7"],
         ["--mass-bounds", "mass bounds 8 to 7 kg leave nothing"]),
        ("box", [*rx90, *pair, "--com-within", "0,1,2"], ["--com-within", "6 finite numbers"]),
        ("empty box", [*rx90, *pair, "--com-within", "1,0,0,1,0,1"], ["--com-within", "is empty"]),
        ("flat ellipsoid", [*rx90, *pair, "--ellipsoid", "0,0,0,1,1,0"], ["--ellipsoid", "must be positive"]),
        ("gain sigma", [*rx90, *pair, "--gain-sigma", "2"], ["'2' is not a share", "2% or 0.02"]),
        ("gain sigma text", [*rx90, *pair, "--gain-sigma", "2%,a,1"], ["--gain-sigma", "percent sign"]),
        ("gain sigma count", [*rx90, *pair, "--gain-sigma", "1%,2%"],
         ["--gain-sigma", "2 uncertainties", "6 joints"]),
        ("common gain sigma", [*rx90, *pair, "--gain-sigma", "common=150%"], ["--gain-sigma", "'150%'"]),
        ("no body", [*rx90, *pair, "--ellipsoid", "0,0,-0.5,0.1,0.1,0.1", "--com-within", "0,1,0,1,0,1",
                     "--mass-bounds", "5,"], ["no body holds all constraints", "mass from 5", "ellipsoid", "box"]),
        ("not JSON", [*rx90, "--robot-parameters", "{bare0}", "--loaded", "{loaded0}"], ["cannot be read as JSON"]),
        ("unknown option", [*rx90, *pair, "--speed", "3"], ["--speed"]),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("arguments", "words"), [case[1:] for case in bad_inputs()], ids=[c[0] for c in bad_inputs()]
)
def test_bad_input_is_one_line_and_writes_nothing(
    run: Run, logs: dict[str, str], tmp_path: Path, arguments: list[str], words: list[str]
) -> None:
    target = tmp_path / "result.json"
    filled = [argument.format(**logs) for argument in arguments]
    status, out, err = run(*filled, *(["--json", str(target)] if filled else []))
    assert status == 2
    lines = [line for line in err.splitlines() if not line.startswith("dynident: note:")]
    assert len(lines) == 1
    assert "error: " in lines[0]
    for word in words:
        assert word in lines[0]
    assert out == ""
    assert not target.exists()
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "command",
    [
        ["weigh", "--robot", "rx90", "--loaded", "x.csv", "--unloaded", "y.csv", "--plots"],
        ["payload", "--robot", "rx90", "--loaded", "x.csv", "--unloaded", "y.csv", "--plots"],
        ["identify", "--robot", "rx90", "--data", "x.csv", "--plots"],
        ["check", "x.csv", "--robot", "rx90", "--plots"],
        ["demo", "--plots"],
        ["design", "--robot", "rx90", "--plots"],
        ["design", "--robot", "rx90", "--val3"],
    ],
    ids=lambda command: f"{command[0]} {command[-1]}",
)
def test_a_folder_that_is_a_file_is_told_before_anything_is_read(
    run: Run, tmp_path: Path, command: list[str]
) -> None:
    blocker = tmp_path / "taken"
    blocker.write_text("mine", encoding="utf-8")
    for wrong in (str(blocker), str(blocker / "inside"), ""):
        status, out, err = run(*command, wrong)
        assert (status, out) == (2, "")
        assert len(err.splitlines()) == 1
        assert f"{command[-1]} {wrong!r}: is not a folder" in err
    assert blocker.read_text(encoding="utf-8") == "mine"
    assert list(tmp_path.iterdir()) == [blocker]


def test_a_folder_that_is_not_there_is_one_line(run: Run, logs: dict[str, str]) -> None:
    status, _, err = run("identify", "--robot", "rx90", "--data", logs["bare0"], "--json", "/nowhere/result.json")
    assert status == 2
    assert "/nowhere/result.json" in err
    assert run("identify", "--robot", "rx90", "--data", logs["bare0"], "--json", "")[0] == 2
    assert run("demo", "--trajectories", "0")[0] == 2
    assert run("demo", "--seed", "-1")[0] == 2


@pytest.mark.long
def test_as_a_program(logs: dict[str, str]) -> None:
    """Exit status and streams of the installed command; also without a compiler."""
    command = [sys.executable, "-c", "import sys; from dynident.cli import main; sys.exit(main())"]
    environment = {**os.environ, "DYNIDENT_NO_COMPILER": "1"}
    bad = subprocess.run(
        [*command, "identify", "--robot", "rx90", "--data", logs["nan"]],
        capture_output=True, text=True, check=False, env=environment,
    )  # fmt: skip
    assert bad.returncode == 2
    assert bad.stdout == ""
    assert "Traceback" not in bad.stderr
    assert len(bad.stderr.splitlines()) == 1
    good = subprocess.run(
        [*command, "identify", "--robot", "rx90", "--data", logs["bare0"], "--details"],
        capture_output=True, text=True, check=False, env=environment,
    )  # fmt: skip
    assert good.returncode == 0
    assert "ZZ1R" in good.stdout
    helped = subprocess.run([*command, "--help"], capture_output=True, text=True, check=True)
    for name in ("payload", "identify", "demo"):
        assert name in helped.stdout
