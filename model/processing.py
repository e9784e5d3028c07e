"""How recordings of a robot are treated: rates, cut-off, decimation, rows that are left out."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Processing:
    """Settings of signal processing, in the order in which they are applied.

    Attributes:
        rate: uniform rate to which a recording is resampled [Hz]; None keeps the recording's mean rate.
        cutoff: cut-off of the zero-phase 4th-order Butterworth filter on positions and speeds [Hz]; None
            leaves them as they are.
        decimate: parallel decimation of Y and of every column of W, by this whole factor.
        still_speed: below it a joint stands still [rad/s or m/s]; while all joints do for over 0.3 s, and where
            they move for under 1 s, rows are left out.
        slow_fraction: rows of joint j are left out where its speed is below this fraction of its largest
            speed, because the sign of the speed is not known there.
        max_mismatch: method 3 refuses a pair whose positions differ by more than this [rad or m].
    """

    rate: float | None = None
    cutoff: float | None = None
    decimate: int = 1
    still_speed: float = 2e-3
    slow_fraction: float = 0.0
    max_mismatch: float = 0.02

    def __post_init__(self) -> None:
        """Refuse settings without a meaning."""
        for name in ("rate", "cutoff"):
            value = getattr(self, name)
            if value is not None and not 0.0 < value < float("inf"):
                raise ValueError(f"{name} must be positive [Hz], got {value}")
        if self.decimate < 1 or self.decimate != int(self.decimate):
            raise ValueError(f"decimate must be a whole number of at least 1, got {self.decimate}")
        if not 0.0 <= self.slow_fraction < 1.0:
            raise ValueError(f"slow_fraction must be in [0, 1), got {self.slow_fraction}")
        for name in ("still_speed", "max_mismatch"):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"{name} must not be negative")
