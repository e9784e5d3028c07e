"""An independent client, ur_rtde (MIT), against the same player: the protocol is spoken and not invented."""

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import pytest
from dynident.tests.live.conftest import Play
from dynident.tests.live.test_record import columns, record

PROGRAM = """
import json, sys, time
from rtde_receive import RTDEReceiveInterface
names = ["timestamp", "actual_q", "actual_qd", "actual_current", "payload", "payload_cog"]
robot = RTDEReceiveInterface(sys.argv[1], 125.0, names)
seen = {}
for _ in range(200):
    seen[robot.getTimestamp()] = [robot.getActualQ(), robot.getActualQd(), robot.getPayload()]
    time.sleep(0.004)
robot.disconnect()
print(json.dumps(sorted(seen.items())))
"""


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="a loopback address of its own is Linux's")
def test_both_clients_read_the_same(play: Play, tmp_path: Path) -> None:
    if importlib.util.find_spec("rtde_receive") is None:
        pytest.skip("an independent client: pip install ur_rtde")
    # Its port is fixed: an address that nobody else listens at. Its constructor holds the interpreter's lock.
    player = play(rate=125, host="127.0.77.19", port=30004)
    answer = subprocess.run(
        [sys.executable, "-c", PROGRAM, "127.0.77.19"], capture_output=True, text=True, timeout=20, check=True
    )
    theirs = json.loads(answer.stdout)
    assert len(theirs) > 50
    out = tmp_path / "a.csv"
    assert record(player, out, "--seconds", "4") == 0
    log = columns(out)
    ours = {round(t, 6): k for k, t in enumerate(log["timestamp"])}
    compared = 0
    for t, (q, qd, _) in theirs:
        # Its fields are read one after the other: a sample may come in between.
        k = ours.get(round(t, 6))
        if k is None:
            continue
        near = range(max(k - 1, 0), min(k + 2, len(log["timestamp"])))
        assert any(all(q[j] == log[f"actual_q_{j}"][m] for j in range(6)) for m in near)
        assert any(all(qd[j] == log[f"actual_qd_{j}"][m] for j in range(6)) for m in near)
        compared += 1
    assert compared > 50
