"""Every key of the documents on fleets and recordings side by side is the value that it comes from."""

from types import SimpleNamespace
from typing import Any

from dynident.apps.fleet.comparing import OddDocument
from dynident.apps.fleet.reduction import ReducedDocument
from dynident.apps.fleet.store import refused_documents
from dynident.apps.report import documents
from dynident.tests.report import made
from dynident.tests.report.every_key import same

ODD: Any = SimpleNamespace(recordings=("a", "b"), odd=(OddDocument("a", "FS1", 5.5),), parameters=("FS1", "M1"))
ODD_KEYS = [{"recording": "a", "parameter": "FS1", "sigmas": 5.5}]


def test_compare() -> None:
    compared: Any = SimpleNamespace(
        **vars(ODD), values=made.numbers(2, 2), sigma=2.0 * made.numbers(2, 2), pooled=made.numbers(2),
        pooled_interval95=3.0 * made.numbers(2, 2), scatter=4.0 * made.numbers(2),
    )  # fmt: skip
    expected = {
        "recordings": compared.recordings, "parameters": compared.parameters, "values": compared.values,
        "sigma": compared.sigma, "pooled": compared.pooled, "pooled_interval95": compared.pooled_interval95,
        "scatter": compared.scatter, "odd": ODD_KEYS,
    }  # fmt: skip
    same(documents.ComparedDocument.of(compared), expected)


def test_fleet_reduce() -> None:
    expected = {
        "store": "s", "new": 3, "known": 2, "workers_lost": 1,
        "refused": [{"file": "a", "reason": "none"}, {"file": "b", "reason": "short"}],
    }  # fmt: skip
    same(ReducedDocument("s", 3, 2, refused_documents({"b": "short", "a": "none"}), 1), expected)


def test_fleet_report() -> None:
    days = ("2026-01-04", "2026-01-05")

    def line(quantity: str, values: Any, own: float, usual: float, z: float | None) -> Any:
        return SimpleNamespace(
            arm="left", quantity=quantity, days=days, usual=usual, values=values, sigma=(0.0, own), z=z
        )

    calm, moved = line("FV1", (0.0, 0.0, 3.5), 0.75, 3.0, None), line("FS1", (*11 * (0.0,), 1.25), 0.5, 2.5, -6.5)
    reported: Any = SimpleNamespace(
        arms=(SimpleNamespace(name="left"),), first="2026-01-01", series=(calm, moved), changed=(moved,), twins=ODD,
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
        "last": [calm_keys, moved_keys], "refused": [{"file": "a.csv", "reason": "none"}],
    }  # fmt: skip
    same(documents.fleet_document(reported, {"a.csv": "none"}), expected)
