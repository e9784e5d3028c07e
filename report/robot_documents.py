"""The robot's essential and constrained parameters as parts of JSON documents."""

from collections.abc import Mapping, Sequence
from typing import Any

from ..estimation import SigmaRatio
from ..estimation.fit import Elimination
from ..estimation.possible import ConstrainedBase, ConstrainedRobot
from ..model import BaseParameters


def elimination_document(
    elimination: Elimination, warnings: Sequence[str] = (), labels: Mapping[str, str] | None = None
) -> dict[str, Any]:
    """How essential parameters were found, and what they are without the others.

    Args:
        elimination: the path and where it ended.
        warnings: what speaks against the set.
        labels: name of a column -> name of the parameter ("MX2" -> "MX2R").
    """
    path, rule, estimate = elimination.path, elimination.rule, elimination.estimate
    named, robust, by_gains = dict(labels or {}), estimate.sigma_robust, estimate.sigma_by_gains
    return {
        "rule": "ratio" if isinstance(rule, SigmaRatio) else "sigma",
        "description": rule.description,
        "essential": len(elimination.essential),
        "sigma_ratio": elimination.sigma_ratio,
        "largest_relative_sigma_percent": 100.0 * elimination.largest_relative_sigma,
        "relative_residual": estimate.fit.relative,
        "parameters": [
            {
                "name": named.get(name, name),
                "value": estimate.values[k],
                "sigma": estimate.sigma[k],
                "sigma_robust": robust[k] if robust is not None else None,
                "sigma_by_gains": by_gains[k] if by_gains is not None else None,
                "relative_sigma_percent": estimate.relative_sigma_percent[k],
            }
            for k, name in enumerate(estimate.names)
        ],
        "path": [
            {
                "eliminated": named.get(name, name) if name else None,
                "remaining": len(path.order) - k,
                "sigma_ratio": path.sigma_ratio[k],
                "largest_relative_sigma_percent": 100.0 * path.largest_relative_sigma[k],
            }
            for k, name in enumerate(["", *path.order])
        ],
        "warnings": list(warnings),
    }


def constrained_document(result: ConstrainedBase | ConstrainedRobot, base: BaseParameters) -> dict[str, Any]:
    """The nearest robot that can exist: base parameters, and with a prior the standard ones, labelled."""
    free = result.free
    nearest = result.nearest if isinstance(result, ConstrainedRobot) else result
    document: dict[str, Any] = {
        "gauge": "prior" if isinstance(result, ConstrainedRobot) else "base",
        "status": result.status,
        "chi2_rise": result.chi2_rise,
        "p_value": result.p_value,
        "active": [holding._asdict() for holding in result.active],
        "min_eigenvalues": {str(link): value for link, value in enumerate(result.min_eigenvalues, start=1)},
        "base_parameters": [
            {"name": name, "value": value, "free": free.values[k], "moved_in_sigma": moved}
            for k, (name, value, moved) in enumerate(
                zip(base.names, result.values, (result.values - free.values) / free.sigma, strict=True)
            )
        ],
        "unidentifiable": list(nearest.unidentifiable),
    }
    if isinstance(result, ConstrainedRobot):
        document["prior"] = {
            "source": result.prior.source,
            "budget": result.budget,
            "weight": result.weight,
            "distances": list(result.distances),
        }
        document["parameters"] = [
            {
                "name": name,
                "value": value,
                **result.origins[name]._asdict(),
                "decided_by": result.origins[name].decided_by(),
            }
            for name, value in result.parameters.items()
        ]
    return document
