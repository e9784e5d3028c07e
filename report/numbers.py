"""Numbers with as many digits as their uncertainty allows."""

import numpy as np

_UNKNOWN = 4  # decimals where no uncertainty is known


def interval_digits(width: float) -> int:
    """Decimals that show two digits of half an interval of that width."""
    if not np.isfinite(width) or width <= 0.0:
        return _UNKNOWN
    return min(max(0, 1 - int(np.floor(np.log10(width / 2.0)))), 9)


def with_interval(value: float, low: float, high: float) -> tuple[str, str]:
    """Value and interval as texts, to the same place; a dash where there is no interval."""
    if not np.isfinite([low, high]).all():
        return f"{value + 0.0:.4g}", "-"
    digits = interval_digits(high - low)
    # Zero has no sign.
    told = [f"{round(number, digits) + 0.0:.{digits}f}" for number in (value, low, high)]
    return told[0], f"{told[1]} to {told[2]}"


def percent(share: float) -> str:
    """A share in percent, three digits; a dash where there is none."""
    return f"{100.0 * share:.3g} %" if np.isfinite(share) else "-"
