"""The frozen runs: a name and a command line each, read in a folder that holds all inputs.

They name nothing of the program but its commands and options, and hold whatever moves inside.
"""

from typing import NamedTuple

_RX = "--unloaded rx_arm_unloaded.csv --loaded rx_arm_loaded.csv"
_UR = "--unloaded ur_arm_unloaded.csv --loaded ur_arm_loaded.csv"
_CURRENTS = "--unloaded ur_currents_unloaded.csv --loaded ur_currents_loaded.csv"
_SIX = "--unloaded six_arm_unloaded.csv --loaded six_arm_loaded.csv"
_TX = "--unloaded tx_arm_unloaded.csv --loaded tx_arm_loaded.csv"
_RX_NEAR = "--unloaded rx_near_unloaded.csv --loaded rx_near_loaded.csv"
_UR_NEAR = "--unloaded ur_near_unloaded.csv --loaded ur_near_loaded.csv"
_GAINS = "11.976,11.976,9.839,10.763,10.757,10.680"
_NOISE = "--torque-noise 24,30,10.8,5.1,6.6,2.3"

_FORMATS = ("abb", "kuka", "ur", "ros2", "franka", "fanuc", "yaskawa", "staubli", "urdf", "sdf", "mjcf", "usd")


class Run(NamedTuple):
    """One command line, and what of its outputs is frozen."""

    name: str
    line: str
    files: tuple[str, ...] = ()
    """Written by it."""
    search: bool = False
    """A design: another motion as good as this will do."""
    score: bool = False
    """Judges a motion that is given, to the digits of the arithmetic."""
    real: bool = False
    """Reads real recordings, from the folder DYNIDENT_DATA."""


RUNS = (
    Run(
        "payload_rx90",
        f"payload --robot rx90 {_RX} --json a.json --report a.html --csv a.csv --latex a.tex",
        ("a.json", "a.html", "a.csv", "a.tex"),
    ),
    Run(
        "payload_ur10e_currents",
        f"payload --robot ur10e {_CURRENTS} --drive-gains {_GAINS} --gain-sigma 2% --decimate 4 --cutoff 8 "
        "--mass 6.2 --mass-sigma 0.05 --json a.json",
        ("a.json",),
    ),
    Run(
        "payload_tx40_stored_robot",
        "payload --robot tx40 --robot-parameters tx_robot.json --loaded tx_arm_loaded.csv --decimate 8 "
        "--json a.json --report a.html",
        ("a.json", "a.html"),
    ),
    Run(
        "payload_tx40_pair",
        f"payload --robot tx40 {_TX} --method 3 --decimate 8 --tool-frame 0,0,0.05,0,0,30 --json a.json",
        ("a.json",),
    ),
    Run(
        "payload_six_axis_constraints",
        f"payload --robot six_axis.toml {_SIX} --mass-min 1 --mass-max 2.6 "
        "--com-within=-0.02,0.02,-0.02,0.05,0,0.1 --ellipsoid 0,0,0.08,0.15,0.15,0.15 --json a.json",
        ("a.json",),
    ),
    Run(
        "weigh_rx90",
        f"weigh --robot rx90 {_RX_NEAR} --details --json a.json --report a.html",
        ("a.json", "a.html"),
    ),
    Run(
        "weigh_rx90_known_mass",
        f"weigh --robot rx90 {_RX_NEAR} --mass 6.2 --mass-sigma 0.02 --json a.json",
        ("a.json",),
    ),
    Run(
        "weigh_ur10e_box",
        f"weigh --robot ur10e {_UR_NEAR} --inertia box:200x200x100 --gain-sigma 2% --json a.json",
        ("a.json",),
    ),
    Run(
        "identify_rx90_essential",
        "identify --robot rx90 --data rx_arm_unloaded.csv --validate rx_near_unloaded.csv --essential-sigma 20% "
        "--json a.json --report a.html --csv a.csv",
        ("a.json", "a.html", "a.csv"),
    ),
    Run(
        "identify_six_axis_prior",
        "identify --robot six_axis.toml --data six_arm_unloaded.csv --constrained prior --prior-mass 40 "
        "--total-mass 20 60 --json a.json",
        ("a.json",),
    ),
    Run(
        "gains_ur10e",
        f"gains --robot ur10e {_CURRENTS} --mass 6.2 --mass-sigma 0.05 --decimate 4 --cutoff 8 --json a.json",
        ("a.json",),
    ),
    Run("check_tx40", "check --robot tx40 tx_arm_unloaded.csv tx_arm_loaded.csv --json a.json", ("a.json",)),
    Run(
        "design_rx90_via_points",
        f"design --robot rx90 --payload-only --via-points 4 --starts 1 --seed 2 {_NOISE} --json a.json",
        ("a.json",),
        search=True,
    ),
    Run(
        "design_rx90_fourier",
        f"design --robot rx90 --payload-only --fourier 2 --duration 3 --starts 1 --criterion cond {_NOISE} "
        "--json a.json",
        ("a.json",),
        search=True,
    ),
    Run(
        "design_rx90_near",
        f"near --robot rx90 --pose=0,-45,90,0,45,0 --joints 4,5,6 --mass 6 --mass-sigma 0.1 --duration 4 "
        f"--speed-override 0.6 {_NOISE} --json a.json",
        ("a.json",),
        search=True,
    ),
    Run(
        "score_rx90_stored_motion",
        f"score rx_arm.csv --robot rx90 {_NOISE} --json a.json",
        ("a.json",),
        score=True,
    ),
    Run(
        "simulate_rx90",
        "simulate --robot rx90 --trajectory rx_short.csv --payload box.toml --rate 50 --seed 7 --out out",
        ("out/rx_short_unloaded.csv", "out/rx_short_loaded.csv", "out/truth.toml"),
    ),
    Run(
        "real_payload_ur10e",
        "payload --robot ur10e --unloaded DYNIDENT_DATA/ur10e/unloaded.csv.gz "
        f"--loaded DYNIDENT_DATA/ur10e/loaded_2.805kg.csv.gz --drive-gains {_GAINS} --json a.json --report a.html",
        ("a.json", "a.html"),
        real=True,
    ),
    Run(
        "real_identify_tx40",
        "identify --robot tx40 --data DYNIDENT_DATA/tx40/tx40.csv.gz --json a.json",
        ("a.json",),
        real=True,
    ),
    Run(
        "fleet_reduce",
        "fleet reduce six_arm_unloaded.csv ur_near_unloaded.csv --robot six_axis.toml --decimate 4 --pattern "
        "{arm}_unloaded.csv --store store --json a.json",
        ("a.json", "store/refused.csv"),
    ),
    Run(
        "fleet_simulate",
        "fleet simulate six_axis.toml --arms 2 --days 3 --rate 50 --points 4 --missing 20% --out out",
        ("out/truth.json", "out/six_axis/truth.csv", "out/six_axis/robots.csv"),
    ),
    Run("robot_show_tx40", "robot show --robot tx40"),
    Run("error_unknown_robot", "check --robot rx91 rx_arm_loaded.csv"),
    Run("error_other_motion", "weigh --robot rx90 --unloaded rx_near_unloaded.csv --loaded rx_arm_loaded.csv"),
    *(
        Run(f"export_{name}", f"export rx_payload.json --to {name} --flange-frame 0 0 0.1 0 0 30")
        for name in _FORMATS
    ),
    Run(
        "export_ur_despite_verdict",
        "export rx_payload.json --to ur --despite-verdict --flange-frame 0 0 0.1 0 0 30",
    ),
)
