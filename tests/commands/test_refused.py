"""Lines that cannot be used: exit status 2, one line that says what, where and what to do, and nothing written.

Users' commonest mistakes are shown in the documentation too, see ``mistakes``.
"""

from pathlib import Path

import pytest
from dynident.tests.commands.mistakes import MISTAKES, PAGE, Mistake, row, write_inputs
from dynident.tests.commands.typed import refused, typed


@pytest.fixture(scope="module")
def mistaken(inputs: Path) -> Path:
    """Good and wrong files, in the working folder."""
    write_inputs()
    for name, source in (
        ("bare", "rx_arm_unloaded"), ("loaded", "rx_arm_loaded"), ("other", "six_arm_loaded"),
        ("currents", "ur_currents_unloaded"),
    ):  # fmt: skip
        (inputs / f"{name}.csv").symlink_to(f"{source}.csv")
    return inputs


@pytest.mark.parametrize("mistake", MISTAKES, ids=lambda mistake: mistake.did)
def test_a_mistake_is_one_line_that_says_where_and_what_to_do(mistake: Mistake, mistaken: Path) -> None:
    before = set(mistaken.rglob("*"))
    ended = typed(mistake.line)
    assert (ended.status, ended.out, len(ended.errors)) == (2, "", 1)
    assert ended.errors[0].startswith("dynident")
    assert mistake.where in ended.errors[0]
    assert mistake.do in ended.errors[0]
    assert set(mistaken.rglob("*")) == before, "nothing is written"
    assert row(mistake, ended.err) in PAGE.read_text(encoding="utf-8").splitlines(), "write the page anew"


def test_the_page_shows_no_more_than_the_table() -> None:
    rows = [line for line in PAGE.read_text(encoding="utf-8").splitlines() if "| `" in line]
    assert len(rows) == len(MISTAKES) >= 60
    assert len({mistake.line for mistake in MISTAKES}) == len(MISTAKES)


RX90 = "--robot rx90"
PAIR = "--unloaded bare.csv --loaded loaded.csv"
NEAR = f"near {RX90} --pose=0,0,90,0,45,0 --joints 2,3,5"
FOURIER = f"design {RX90} --fourier 3"
DESIGN = f"design {RX90}"
NOISY = f"{DESIGN} --torque-noise 1,1,1,1,1,1"
BAND = "--heaviest-payload 2@0,0,0.1 --within 0.1"
HELD = f"near --robot ur10e --pose=0,-90,110,-110,-90,0 --joints 2,3,5,6 --duration 6 {BAND}"
ARM = (
    "robot new --name kr --joint=-z,0,0,0.4 --joint y,0.025,0,0.4 --joint y,0.025,0,0.855 --joint=-x,0.025,0,0.89 "
    "--joint y,0.445,0,0.89 --joint=-x,0.525,0,0.89"
)
NEW = f"{ARM} --flange 0.525,0,0.89,x,-z"
LINES = {
    f"payload {RX90} {PAIR}": {
        "--cutoff -1": "cutoff must be above 0 Hz",
        "equation-rate=0": "equation_rate must be above 0 Hz",
        "--method 3 free-friction=true": "free-friction belongs",
        "--mass -7+-0.1": "a mass above 0 kg",
        "--com-within 1,0,0,1,0,1": "is empty",
        "--ellipsoid 0,0,0,1,1,0": "must be positive",
        "--gain-sigma 2%,a,1": "percent sign",
        "--gain-sigma common=150%": "'150%'",
        "--ellipsoid 0,0,-0.5,0.1,0.1,0.1 --com-within 0,1,0,1,0,1 --mass-bounds 5,": "no body holds all",
        "--method 1 essential=1.05": "belongs to --method 4 or all",
    },
    f"payload {RX90} --unloaded bare.csv --loaded other.csv": {"--method 3": "not the same trajectory"},
    f"payload --robot ur10e {PAIR}": {"coulomb=paper": "no coupled drives"},
    f"identify {RX90} --data": {
        "currents.csv --drive-gains a": "'a'",
        "gap.csv": "record without losing rows",
        "latin.csv": "found t, q1, Drehmoment_Größe",
        "bare.csv equation-rate=0.001": "raise equation-rate",
        "bare.csv --cutoff 1e-9": "raise --cutoff",
        "bare.csv rate=0.01": "raise rate",
        "bare.csv rate=1e8": "lower rate",
        "bare.csv --validate dead.csv": "joint 4",
        "bare.csv --npz /nowhere/out": "--npz '/nowhere/out'",
        "bare.csv --constrained none --total-mass 1 9": "--total-mass belongs to --constrained base or prior",
        "bare.csv --constrained base --prior-mass 30": "--prior-mass belongs to --constrained prior, not to base",
        "bare.csv --constrained prior --prior-mass -3": "must be positive",
        "bare.csv --constrained prior prior-budget=0": "budget 0",
        "bare.csv --total-mass 9 1": "give low <= high",
        "bare.csv --total-mass -9 -1": "high above 0",
        "bare.csv essential=1": "must be above 1",
        "bare.csv essential=-5%": "write 2% or 0.02",
        "bare.csv essential=few": "is not a number",
        # The reduction would refuse the joint that stands still: it was not reached.
        "still.csv --gain-sigma 1%,2%": "2 uncertainties of drive gains for 6 joints",
    },
    f"weigh {RX90} {PAIR}": {"--inertia ball:3": "box:60x60x350"},
    f"gains --robot ur10e {PAIR}": {
        "--mass -1": "a mass above 0 kg",
        "--payload none.toml": "none.toml: no such file",
        "--payload x.toml --mass 1": "give either --mass or --payload",
    },
    f"check {RX90} bare.csv": {
        "--log-map none.toml": "none.toml: no such file",
        "signs=1,2,1,1,1,1": ".toml: signs: sign must be 1 or -1",
        "--joints a,a,b,c,d,e": "error: --joints: a joint is named twice",
    },
    "check bare.csv": {"--mount wall": "--mount has no effect without --robot"},
    f"near {RX90}": {"--pose=0,0,90,0,45,0": "give --joints", "--joints 2,3": "give --pose"},
    NEAR: {
        "--range=-3": "one positive number",
        "--bound": "Unknown option: --bound",
        "--mass 3,4": "is not one mass",
        "--second-pose 1,2": "give one each",
        "--second-pose=0,-90,90,0,999,0": "within the limits of rx90 (joint 5: -105 to 120 deg)",
        "--torque-noise 1 --like b.json": "give one of them",
        "--no-floor scene=s.toml": "--no-floor and scene: give one of them",
        "sample-rate=100": "has no effect without --samples",
        "--poses 9": "--poses has no effect without --static",
        "--static --duration 9": "--duration and --static: give one of them",
        "--static hold=0.5": "needs 1 to 10 s at rest, not 0.5",
        "--static --range 2": "joint 2 has 4 deg of room in its range: none for a pose and 3 deg to either side",
        "--static approach=-3": "-3 deg to either side",
        "--static --torque-noise 1%@10": "omit @HZ",
        "--static rehearsal=x.csv": "at a low speed override",
    },
    HELD: {
        "--mass 5+-0.01": "5 kg are expected and --heaviest-payload allows 2: give another --mass",
        "--mass 7 --ladder": "7 kg are expected and --heaviest-payload allows 2: give another --mass",
    },
    NOISY: {
        "ramp=0.2": "ramp belongs to --segments trapezoid",
        "--segments trapezoid ramp=0.7": "a ramp of 0.7 of a move's time",
        "--fourier 3 ramp=0": "ramp belongs to --via-points",
        "--fourier 3 --segments quintic": "--segments belongs to --via-points",
        "segment-durations=1,2": "fixed durations 1, 2: 14 via points need 13",
        "segment-durations=1 --max-duration 20": "--max-duration has no effect",
    },
    FOURIER: {
        "--duration 1e6": "in up to 3600 s",
        "--max-duration 5": "--fourier takes --duration",
        "--rest": "--rest belongs to --via-points",
        "--val3 x": "Fourier motion has none",
    },
    DESIGN: {
        "--arm-mass 50 --via-points 4": "--arm-mass has no effect",
        "--criterion e": 'Invalid value "e" for --criterion',
        "--columns payload parameters=M": "cannot design for these parameters of robot 'rx90': M",
        "--via-points 5 --fourier 3": "give one of them",
        "--via-points 2": "a whole number from 3",
        "--fourier 1": "give at least 2",
        "--via-points 1000000": "give 2 to 500",
        "segment-durations=1e9": "need 13 positive ones",
        "--duration 5": "via points take --max-duration",
        "--duration -1": "not a number above 0",
        "--speed-override 1.5": "speed override is 1.5",
        "acceleration=0x": "not a factor such as 3x",
        "acceleration=1,2": "2 numbers for 6 joints",
        "--torque-limits 1,2": "2 numbers for 6 joints",
        "--torque-noise 10% --torque-limits none": "needs a torque limit of every joint",
        "--torque-noise 1,2": "2 numbers for 6 joints",
        "--start 1,2,3": "3 numbers for the 6 joints",
        "--start 0,0,0,0,121,0": "within the limits of rx90 (joint 5: -105 to 120 deg)",
        "parameters=XX9": "XX9",
        "parameters=FV1,FV1": "not a list of different names",
        "--columns XX1,ZZ1": "XX1 has no effect",
        "--criterion cond parameters=FV1": "counts for d and a only",
        "--columns payload --criterion a": "needs reference values",
        "--heaviest-payload 7 --torque-limits none": "give --torque-limits",
        "--heaviest-payload heavy --torque-limits 1,1,1,1,1,1": "give kg, kg@x,y,z (m), or a TOML",
        "--within 0.1": "--within has no effect without --heaviest-payload",
        "--heaviest-payload 7 --within box:1,2": "is not R, A,B,C or box:A,B,C",
        "--heaviest-payload x.toml --within 0.1": "x.toml is one",
        "--heaviest-payload 7 --within 0.1 --torque-limits none": "a torque limit of every joint",
        "torque-margin=100%": "'100%' is not a fraction",
        "torque-margin=10% --torque-limits none": "no effect without torque limits",
        "scene=nowhere.toml": "no such file",
        "--robot-parameters nowhere.json": "no such file",
        "--data-from nowhere.npz": "needs data-length",
        "joint-names=a,b": "no effect without --ros2",
        "joint-names=a,b --ros2 x.yaml": "6 different ones",
        "sample-rate=100": "no effect without --samples or --ros2",
        "--urscript x controller-rate=250": "500 Hz (e-Series) or 125 Hz",
        "--val3 no-name": "not a VAL3 application name",
        "--samples nowhere/x.csv": "no file can be written there",
        "--ros2 nowhere/x.yaml": "no file can be written there",
        "--starts 0": "from 1 to",
    },
    f"score {RX90}": {
        "": "give --data",
        "nowhere.csv --samples x.csv": "Unknown option: --samples",
        "nowhere.csv --segments trapezoid": "Unknown option: --segments",
        "nowhere.csv --starts 3": "Unknown option: --starts",
        "nowhere.csv seed=3": "seed has no effect without bound",
    },
    f"simulate {RX90} --out x": {
        "--noise loud": "--noise 'loud'",
        "--rate 1": "not a rate",
        "gain-error=2": "not a fraction",
        "--sag 0": "not above 0",
        "--sag 4": "give --payload, and --controller proportional or gravity",
        "--trajectory bare.csv --trajectory bare.csv": "two files are called 'bare'",
    },
    "demo": {"--trajectories 0": "--trajectories", "--seed -1": "--seed"},
    ARM: {"": "give --flange", "--flange 0,0,0,x,1:1:0": "two directions at right angles"},
    NEW: {
        "--joint w,0,0,0": "--joint: 'w,0,0,0' is not AXIS,X,Y,Z",
        "--joint x,0,0": "AXIS,X,Y,Z",
        "--joint 0:0:0,0,0,0": "direction",
        "--limits 1:2": "--limits has 1 parts for 6 joints",
        f"--limits {','.join(['2:1'] * 6)}": "--limits of joint 1",
        "--limits 1:2:fast": "'fast' is not a number",
        "drawn-at=1,2": "drawn-at has 2 parts for 6 joints",
        "--mass 0": "mass must be positive",
        "--rated-payload -1": "rated payload must be positive",
        "--drawing x.gif": "ends in .png or .svg or .pdf",
    },
    "robot show --robot panda": {
        "--at 1,2": "--at: 2 numbers for the 7 joints of robot 'panda'",
        "chain=:x": "links of a URDF",
        "--mount gravity=0,9": "not 3 numbers",
        "--mount table": "'table' is not 3 numbers",
        "--tool-frame 1,2,3": "not 6 numbers",
    },
    "robot export --robot panda": {"--to urdf --out x.urdf": "bodies need all ten"},
    f"codegen {RX90} --function": {
        "mass --out new": "give one of inverse_dynamics, ",
        "gravity --out bare.csv": "is a file, not a folder",
        "gravity --out bare.csv/x": "bare.csv",
    },
}
"""The beginning of lines, what is typed behind it, and what the answer must hold."""
TYPED = [(f"{begin} {more}", words) for begin, ends in LINES.items() for more, words in ends.items()]


@pytest.mark.parametrize(("line", "words"), TYPED, ids=[line[:90] for line, _ in TYPED])
def test_what_cannot_be_used(mistaken: Path, line: str, words: str) -> None:
    before = set(mistaken.rglob("*"))
    assert words in refused(line)
    assert set(mistaken.rglob("*")) == before
