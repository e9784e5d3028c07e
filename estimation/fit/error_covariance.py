"""The covariance that an estimate's errors really have: the formula's correlations, robust standard deviations."""

from dataclasses import replace

import numpy as np

from ...common.arrays import Array
from .estimate import Estimate


def error_model(estimate: Estimate, extra: Array | None = None) -> Estimate:
    """An estimate with the covariance that its errors really have, and the degrees of freedom of that.

    C = S C_formula S + C_gains + ``extra`` with S = diag(sigma_robust / sigma): from a few dozen blocks the
    jackknife knows standard deviations well, ten directions not; the correlations are the formula's. Without robust
    standard deviations S = 1.

    Args:
        estimate: of one method, or of the robot.
        extra: covariance of what all recordings share, as errors of the drive gains; the robot's own estimate
            brings that of the gains itself.
    """
    C, dof, robust = estimate.covariance, estimate.degrees_of_freedom, estimate.robust
    if robust is not None:
        ratio = robust.sigma / np.where(estimate.sigma > 0.0, estimate.sigma, 1.0)
        C, dof = C * np.outer(ratio, ratio), float(robust.degrees_of_freedom)
    for more in (extra, estimate.covariance_by_gains):
        C = C if more is None else C + more
    return replace(estimate, covariance=C, degrees_of_freedom=dof, robust=None, gain_covariance=None)
