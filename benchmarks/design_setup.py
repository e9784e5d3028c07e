"""The RX90 of the design benchmarks: limits, noise, parameters, obstacles; and how their tables look."""

from dynident.examples.paper.printed import paper_tables
from dynident.model import load_robot
from dynident.trajectories import JointBounds, Scene
from dynident.trajectories.design.scene import Capsule, HalfSpace
from rich.console import Console
from rich.table import Table

SEEDS = range(5)
ROBOT = load_robot("rx90")
TORQUE = (300.0, 300.0, 120.0, 50.0, 40.0, 20.0)
STRONG = [3.0 * joint.limits.speed for joint in ROBOT.joints]
GUARDED = JointBounds.of(ROBOT, acceleration=STRONG, torque=TORQUE)
NOISE_OF_LIMITS = tuple(0.1 * torque for torque in TORQUE)
TABLE2 = {name: printed.value for name, printed in paper_tables().table2_robot.items()}
NOISE = tuple(0.1 * TABLE2[f"FS{j + 1}"] for j in range(ROBOT.n))
SCENE = Scene(
    (
        Capsule("column", 0, 0.20, (0.0, 0.0, -0.42), (0.0, 0.0, 0.10)),
        Capsule("upper arm", 2, 0.12, (0.0, 0.0, 0.0), (0.45, 0.0, 0.0)),
        Capsule("elbow", 3, 0.15),
        Capsule("wrist", 4, 0.10),
        Capsule("tool", 6, 0.12, (0.0, 0.0, 0.2)),
    ),
    (HalfSpace("floor", offset=-0.42),),
    (
        ("tool", "column"),
        ("wrist", "column"),
        ("elbow", "column"),
        ("tool", "upper arm"),
        ("tool", "elbow"),
        ("wrist", "upper arm"),
    ),
)
console = Console(width=116, highlight=False)


def titled(title: str, *headings: str) -> Table:
    table = Table(title=title, box=None)
    table.add_column("")
    for heading in headings:
        table.add_column(heading, justify="right")
    return table
