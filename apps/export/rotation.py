"""Principal axes and quaternions as controllers write them."""

from itertools import permutations, product

import numpy as np

from ...common.arrays import Array


def principal_axes(inertia: Array) -> tuple[Array, Array]:
    """Moments (3,) and axes (columns, 3 x 3) with inertia = R diag(moments) R', det R = +1.

    Of the 24 right-handed choices the one that turns least against the frame's own axes, so that a diagonal inertia
    keeps its order and gets no rotation.
    """
    off = inertia - np.diag(np.diag(inertia))
    if not off.any():
        return np.diag(inertia).copy(), np.eye(3)
    moments, axes = np.linalg.eigh(inertia)
    choices = [
        (order, np.array(signs) * axes[:, order])
        for order in (list(p) for p in permutations(range(3)))
        for signs in product((1.0, -1.0), repeat=3)
    ]
    right_handed = [(order, R) for order, R in choices if np.linalg.det(R) > 0.0]
    order, R = max(right_handed, key=lambda choice: float(np.trace(choice[1])))
    return moments[order], R


def quaternion(R: Array) -> Array:
    """Unit quaternion (w, x, y, z) of a rotation matrix, w >= 0, shape (4,)."""
    # Largest eigenvector of the symmetric 4 x 4 form: no branch, good for every rotation (Bar-Itzhack, 2000).
    K = np.empty((4, 4))
    K[0, 0] = np.trace(R)
    K[0, 1:] = K[1:, 0] = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
    K[1:, 1:] = R + R.T - np.trace(R) * np.eye(3)
    q = np.linalg.eigh(K)[1][:, -1]
    leading = q[0] if abs(q[0]) > 1e-12 else q[np.argmax(np.abs(q))]
    return np.asarray(q * np.sign(leading)) + 0.0
