"""Weighing on the command line, from the design to the exported file."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.logs import read_trajectory
from dynident.model import load_robot
from dynident.tests.commands.lines import save
from dynident.tests.commands.typed import Answer, answered, typed

NEAR = "near --robot rx90 --pose=0,-45,90,0,45,0 --speed-override 0.5 --duration 12"


def _write(folder: Path) -> None:
    """Designed motions of arm and wrist, and of the wrist alone, run by a simulated controller."""
    load = "mass = 7.02\ncom = [0.01, -0.02, 0.15]\ninertia_com = [0.03, 0, 0, 0.03, 0, 0.015]\n"
    (folder / "payload.toml").write_text(load, encoding="utf-8")
    for name, joints in (("arm", "2,3,5,6"), ("wrist", "4,5,6 --mass 7.02+-0.02")):
        motion = folder / f"{name}.csv"
        assert typed(f"{NEAR} --joints {joints} --samples {motion} --sample-rate 125").status == 0
        run = f"--trajectory {motion} --payload {folder}/payload.toml --seed 1 --out {folder}"
        assert typed(f"simulate --robot rx90 {run}").status == 0


@pytest.fixture
def pairs(shared: Callable[[str, Callable[[Path], object]], Path], here: Path) -> Path:
    for path in shared("weighing", _write).glob("*loaded.csv"):
        (here / path.name).symlink_to(path)
    return here


def weighed(name: str, more: str = "", status: tuple[int, ...] = (0,)) -> Answer:
    pair = f"--unloaded {name}_unloaded.csv --loaded {name}_loaded.csv"
    return answered(f"weigh --robot rx90 {pair} {more}", status=status)


def test_visibility_and_sigma_before_any_motion(here: Path) -> None:
    document, text = answered(f"{NEAR} --joints 2,3,5,6 --samples motion.csv --sample-rate 125")
    assert "Visible to joints 2, 3, 5, 6: 10 of 10" in text
    assert document["visibility"]["rank"] == 10
    assert document["predicted_sigma"]["mass"] < 0.13
    assert max(document["predicted_sigma"]["com"]) < 8.4e-3
    assert (document["limits"]["max_violation"], document["limits"]["torque_checked"]) == (0.0, True)
    assert all(limit["room"] >= 0.0 for limit in document["limits"]["nearest"])
    assert "Assumed, not published: torque limits" in text
    robot = load_robot("rx90")
    (_, _, fast, _), (t, _, slow, _) = (
        read_trajectory(here / f"motion{end}.csv", robot) for end in ("", "_rehearsal")
    )
    assert fast is not None
    assert slow is not None
    assert np.abs(slow).max() == pytest.approx(0.1 * np.abs(fast).max(), rel=1e-3)
    assert t[-1] == pytest.approx(document["rehearsal_s"])
    assert "REHEARSAL" in (here / "motion_rehearsal.csv").read_text(encoding="utf-8")


@pytest.mark.long
def test_refused_after_the_motion_accepted_with_the_mass(pairs: Path) -> None:
    ended = typed("weigh --robot rx90 --unloaded wrist_unloaded.csv --loaded wrist_loaded.csv --json w.json")
    assert (ended.status, Path("w.json").exists()) == (2, False)
    assert "mass not visible" in ended.err
    document, _ = weighed("wrist", "--mass 7.02+-0.02")
    assert document["mass_from_scale"]
    assert document["quantities"]["mass"]["use"] == "weighed"
    assert document["visibility"]["parameters"]["M"] == "no"
    moving = typed("weigh --robot rx90 --unloaded arm_unloaded.csv --loaded arm_loaded.csv --moving 1,2")
    assert moving.status == 2
    assert "does not move" in moving.err


@pytest.mark.long
@pytest.mark.parametrize("inertia", ["", "--inertia box:60x60x350"])
def test_assumed_inertia_is_labelled_down_to_the_controller(pairs: Path, inertia: str) -> None:
    """And without an assumption a point mass is exported."""
    document, text = weighed("arm", inertia)
    (pairs / "w.json").write_text(json.dumps(document))
    assert ("Inertia ASSUMED" in text) == (document["quantities"]["inertia"]["use"] == "assumed") == bool(inertia)
    torques = document["constant_torques"]
    assert set(torques["joints"]) <= {2, 3}  # the arm's that move
    assert [sigma > 0.0 for sigma in torques["sigma"]] == [j in torques["joints"] for j in range(1, 7)]
    for name in ("ur", "abb", "staubli", "urdf", "mjcf"):
        ended = typed(f"export w.json --to {name} --flange-frame 0 0 0 0 0 0")
        assert ended.status == 0
        assert ("ASSUMED" in ended.out + ended.err) == bool(inertia)
        if name == "staubli":
            moments = [float(line.split()[-1]) for line in ended.out.splitlines() if line.startswith("Izz")]
    box = document["quantities"]["mass"]["value"] * (0.06**2 + 0.06**2) / 12.0
    assert moments == pytest.approx([box] if inertia else [], rel=2e-3)  # as many digits as the mass supports


def test_verify(here: Path) -> None:
    t = np.arange(1000) / 100.0
    q = 0.4 * np.sin(np.outer(t, [1.3, 1.1, 1.7, 2.3, 0.9, 1.4]))
    for name, share in (("before", 1.0), ("after", 0.7)):
        error = 1e-3 * share * np.cos(np.outer(t, [2.0, 3.0, 2.5, 1.9, 2.2, 2.8]))
        save(f"{name}.csv", t, q, 30.0 * np.cos(q), q + error, names="q,tau,qref")
    document, text = answered("verify --robot rx90 --before before.csv --after after.csv")
    assert "The following error fell by 30.0 %" in text
    assert document["all"]["fall"] == pytest.approx(0.3, abs=1e-6)
    harmful = typed("verify --robot rx90 --before after.csv --after before.csv")
    assert harmful.status == 1
    assert "does harm" in harmful.out
