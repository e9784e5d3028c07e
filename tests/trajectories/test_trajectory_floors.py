"""Within trajectories: what designs a motion and what simulates one do not know each other."""

import pytest
from dynident.tests.test_floors import MODULES, imported


@pytest.mark.parametrize(("floor", "partner"), [("design", "simulation"), ("simulation", "design")])
def test_neither_imports_the_other(floor: str, partner: str) -> None:
    files = [name for name in MODULES if name.startswith(f"trajectories.{floor}.")]
    assert len(files) > 5
    targets = {target for name in files for target in imported(name)}
    assert not {target for target in targets if target.startswith(f"trajectories.{partner}")}
    assert any(target.startswith("trajectories.motions.") for target in targets)
