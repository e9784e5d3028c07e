"""The frozen runs: a name and a command line each, read in a folder that holds all inputs.

They name nothing of the program but its commands and options, and hold whatever moves inside.
"""

from typing import NamedTuple

_RX = "--robot rx90 --unloaded rx_arm_unloaded.csv --loaded rx_arm_loaded.csv"
_RX_NEAR = "--robot rx90 --unloaded rx_near_unloaded.csv --loaded rx_near_loaded.csv"
_UR_NEAR = "--robot ur10e --unloaded ur_near_unloaded.csv --loaded ur_near_loaded.csv"
_CURRENTS = "--robot ur10e --unloaded ur_currents_unloaded.csv --loaded ur_currents_loaded.csv"
_REPEATS = " ".join(f"--unloaded rx_{x}_unloaded.csv --loaded rx_{x}_loaded.csv" for x in ("one", "two", "three"))
_SIX = "--robot six_axis.toml --unloaded six_arm_unloaded.csv --loaded six_arm_loaded.csv"
_TX = "--robot tx40 --unloaded tx_arm_unloaded.csv --loaded tx_arm_loaded.csv"
_TX_REAL = "DYNIDENT_DATA/tx40/tx40.csv.gz"
_UR_REAL = "--unloaded DYNIDENT_DATA/ur10e/unloaded.csv.gz --loaded DYNIDENT_DATA/ur10e/loaded_2.805kg.csv.gz"
_GAINS = "--drive-gains 11.976,11.976,9.839,10.763,10.757,10.680"
_WEIGHED = "--mass 6.2+-0.05 equation-rate=25 --cutoff 8"
_NOISE = "--torque-noise 24,30,10.8,5.1,6.6,2.3"
_DESIGN = f"design --robot rx90 --columns payload --starts 1 {_NOISE}"


class Run(NamedTuple):
    """One command line, which gets ``--json a.json`` at its end."""

    name: str
    line: str

    @property
    def searched(self) -> bool:
        """A design: another motion as good as this will do."""
        return self.line.startswith(("design", "near"))

    @property
    def scored(self) -> bool:
        """Judges a motion that is given, to the digits of the arithmetic."""
        return self.line.startswith("score")

    @property
    def real(self) -> bool:
        """Reads real recordings, from the folder DYNIDENT_DATA."""
        return "DYNIDENT_DATA" in self.line


RUNS = (
    Run("payload_rx90", f"payload {_RX}"),
    Run("payload_ur10e_currents", f"payload {_CURRENTS} {_GAINS} --gain-sigma 2% {_WEIGHED}"),
    Run(
        "payload_tx40_stored_robot",
        "payload --robot tx40 --robot-parameters tx_robot.json --loaded tx_arm_loaded.csv equation-rate=25",
    ),
    Run("payload_tx40_pair", f"payload {_TX} --method 3 equation-rate=25 --tool-frame 0,0,0.05,0,0,30"),
    Run(
        "payload_six_axis_constraints",
        f"payload {_SIX} --mass-bounds 1,2.6 --com-within=-0.02,0.02,-0.02,0.05,0,0.1 "
        "--ellipsoid 0,0,0.08,0.15,0.15,0.15",
    ),
    Run("weigh_rx90", f"weigh {_RX_NEAR}"),
    Run("weigh_rx90_known_mass", f"weigh {_RX_NEAR} --mass 6.2+-0.02"),
    Run("weigh_rx90_repeats", f"weigh --robot rx90 {_REPEATS}"),
    Run(
        "weigh_rx90_wrist",
        "weigh --robot rx90 --unloaded rx_wrist_unloaded.csv --loaded rx_wrist_loaded.csv --mass 6.2+-0.02",
    ),
    Run(
        "weigh_six_axis_static",
        "weigh --static --robot six_axis.toml --unloaded six_rest_unloaded.csv --loaded six_rest_loaded.csv",
    ),
    Run("weigh_ur10e_box", f"weigh {_UR_NEAR} --inertia box:200x200x100 --gain-sigma 2%"),
    Run(
        "identify_rx90_essential",
        "identify --robot rx90 --data rx_arm_unloaded.csv --validate rx_near_unloaded.csv essential=20%",
    ),
    Run(
        "identify_six_axis_prior",
        "identify --robot six_axis.toml --data six_arm_unloaded.csv --constrained prior --prior-mass 40 "
        "--total-mass 20 60",
    ),
    Run(
        "identify_rx90_rollout",
        "identify --robot rx90 --data rx_arm_unloaded.csv --validate rx_near_unloaded.csv --rollout "
        "--gain-sigma 2%",
    ),
    Run("compare_rx90", "compare --robot rx90 rx_arm_unloaded.csv rx_arm_loaded.csv"),
    Run("gains_ur10e", f"gains {_CURRENTS} {_WEIGHED}"),
    Run("check_tx40", "check --robot tx40 tx_arm_unloaded.csv tx_arm_loaded.csv"),
    Run("robot_check_rx90", "robot check --robot rx90 --data rx_arm_unloaded.csv"),
    Run("rollout_tx40", "rollout --robot tx40 --robot-parameters tx_robot.json --data tx_arm_unloaded.csv"),
    Run("design_rx90_via_points", f"{_DESIGN} --via-points 4 --seed 5"),
    Run("design_rx90_fourier", f"{_DESIGN} --fourier 2 --duration 3 --criterion cond"),
    Run(
        "design_rx90_near",
        "near --robot rx90 --pose=0,-45,90,0,45,0 --joints 4,5,6 --mass 6+-0.1 --duration 4 "
        f"--speed-override 0.6 {_NOISE}",
    ),
    Run("score_rx90_stored_motion", f"score rx_arm.csv --robot rx90 {_NOISE}"),
    Run(
        "fleet_reduce",
        "fleet reduce six_arm_unloaded.csv ur_near_unloaded.csv --robot six_axis.toml equation-rate=31.25 "
        "--pattern {arm}_unloaded.csv --store store",
    ),
    Run("real_payload_ur10e", f"payload --robot ur10e {_UR_REAL} {_GAINS} --friction paper"),
    Run("real_identify_tx40", f"identify --robot tx40 --data {_TX_REAL} --friction paper"),
    Run("real_payload_ur10e_friction", f"payload --robot ur10e {_UR_REAL} {_GAINS}"),
    Run("real_identify_tx40_friction", f"identify --robot tx40 --data {_TX_REAL}"),
)
