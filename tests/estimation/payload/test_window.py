"""The moving window of a stream: what its blocks say of their own errors."""

import numpy as np
from dynident.estimation import identify
from dynident.estimation.payload.live import LiveWeighing
from dynident.estimation.payload.window import MovingWindow
from dynident.model import Motion, load_robot
from dynident.trajectories import RX90_NOISE, Simulator, random_via_points


def test_a_joint_that_hardly_moved_tells_nothing_of_its_errors() -> None:
    """A few rows are fitted exactly by the joint's friction: a size of their errors would be rounding."""
    simulator, noise = Simulator(load_robot("rx90")), np.array(RX90_NOISE)
    bare = simulator.record(random_via_points(simulator.robot, 14, seed=1).motion(100.0), noise=noise)
    window = MovingWindow(simulator.robot, identify(simulator.robot, [bare]).estimate)
    weighing, sizes = LiveWeighing(window), list[float]()
    for _ in weighing.feed(simulator.record(turned_late(), noise=noise, seed=4)):
        sizes.append(float(window.held.noise[0]))
    assert all(size == 0.0 or 0.2 * noise[0] < size < 5.0 * noise[0] for size in sizes)
    assert 0 < sum(len(block.equations.Y[0]) for block in window.blocks) < 6
    assert not weighing.changes


def turned_late() -> Motion:
    """All joints swing but the first, which turns by three degrees at the end."""
    t = np.arange(1200) / 100.0
    share = np.clip((t - 10.2) / 0.6, 0.0, 1.0)
    turned = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    q = np.column_stack([0.05 * turned, 0.6 * np.sin(np.outer(t, [0.9, 1.1, 1.7, 1.9, 2.3]))])
    qd = np.gradient(q, t, axis=0)
    return Motion(t, q, qd, np.gradient(qd, t, axis=0))
