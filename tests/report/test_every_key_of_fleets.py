"""Every key of the documents on fleets and recordings side by side is the value that it comes from."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

from dynident.apps.report import documents
from dynident.tests.report import made
from dynident.tests.report.every_key import same

ODD: Any = SimpleNamespace(sources=("a", "b"), odd=[("a", "FS1", 5.5)], names=("FS1", "M1"))
ODD_KEYS = [{"recording": "a", "parameter": "FS1", "sigmas": 5.5}]


def test_compare() -> None:
    compared: Any = SimpleNamespace(
        **vars(ODD), values=made.numbers(2, 2), sigma=2.0 * made.numbers(2, 2), pooled=made.numbers(2),
        interval95=3.0 * made.numbers(2, 2), scatter=4.0 * made.numbers(2),
    )  # fmt: skip
    expected = {
        "recordings": compared.sources, "parameters": compared.names, "values": compared.values,
        "sigma": compared.sigma, "pooled": compared.pooled, "pooled_interval95": compared.interval95,
        "scatter": compared.scatter, "odd": ODD_KEYS,
    }  # fmt: skip
    same(documents.compared_document(compared), expected)


def test_fleet_reduce() -> None:
    reduced: Any = SimpleNamespace(
        store=SimpleNamespace(root=Path("s")),
        new=3,
        known=2,
        crashes=1,
        refused={"b": "short", "a": "none"},
    )
    expected = {
        "store": "s", "new": 3, "known": 2, "workers_lost": 1,
        "refused": [{"file": "a", "reason": "none"}, {"file": "b", "reason": "short"}],
    }  # fmt: skip
    same(documents.reduced_document(reduced), expected)


def test_fleet_report() -> None:
    exchange = {"arm": "left", "day": "2026-01-04", "alone": True, "chi2": 99.5, "degrees": 24, "like": "right"}
    night: Any = SimpleNamespace(day="2026-01-05", numbers={"FS1": (1.25, 0.5), "FV1": (3.5, 0.75)})
    calm: Any = SimpleNamespace(arm="left", quantity="FV1", usual=3.0, values=made.numbers(3), z=None)
    moved: Any = SimpleNamespace(arm="left", quantity="FS1", usual=2.5, values=made.numbers(12), z=-6.5)
    reported: Any = SimpleNamespace(
        arms=(SimpleNamespace(name="left", nights=(night,)),), first="2026-01-01", series=(calm, moved),
        changed=(moved,), twins=ODD, exchanges=(SimpleNamespace(**exchange),),
    )  # fmt: skip
    calm_keys = {
        "arm": "left", "quantity": "FV1", "day": "2026-01-05", "value": 3.5, "sigma": 0.75, "usual": 3.0,
        "nights": 2, "z": None,
    }  # fmt: skip
    moved_keys = {
        "arm": "left", "quantity": "FS1", "day": "2026-01-05", "value": 1.25, "sigma": 0.5, "usual": 2.5,
        "nights": 11, "z": -6.5,
    }  # fmt: skip
    expected = {
        "arms": ["left"], "first_day": "2026-01-01", "threshold": 5.0, "changed": [moved_keys], "odd": ODD_KEYS,
        "last": [calm_keys, moved_keys], "exchanges": [exchange], "refused": [{"file": "a.csv", "reason": "none"}],
    }  # fmt: skip
    same(documents.fleet_document(reported, {"a.csv": "none"}), expected)
