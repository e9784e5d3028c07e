"""Largest values of quadratics in three unknowns over the unit ball and the unit cube, as CasADi expressions.

Over the ball: the trust-region problem, solved to global optimality by its dual (Conn, Gould and Toint,
Trust-Region Methods, chapter 7). In the eigenvectors of Q, with beta = V' b / 2,

    max over |s| <= 1 of s' Q s + b' s  =  min over mu >= max(0, lambda) of mu + sum beta_i^2 / (mu - lambda_i),

and every such mu bounds the left side from above: what is returned is a bound wherever the iteration stands. Over
the cube the largest value is a stationary point of its inside, of a face, of an edge, or a corner: 27 candidates.
"""

from itertools import product
from typing import NamedTuple

import casadi as ca

_SWEEPS = 4  # of Jacobi's rotations: a 3 x 3 matrix is then diagonal to rounding
_NEWTON = 8  # steps: with seven, rows of the shipped arms were bounded to 1e-12, with eight to rounding
_TINY = 1e-13  # of the quadratic's size: distance that mu keeps from the largest eigenvalue
_LEAST = 1e-300


class Extreme(NamedTuple):
    """Largest value, and the place where it is taken (three expressions)."""

    value: ca.SX
    place: list[ca.SX]


class Eigen(NamedTuple):
    """Eigenvalues, and a matrix whose columns are the eigenvectors."""

    values: list[ca.SX]
    vectors: list[list[ca.SX]]


def eigen(Q: ca.SX) -> Eigen:
    """Eigenvalues and eigenvectors of a symmetric 3 x 3 matrix by Jacobi's rotations."""
    A = [[Q[i, j] for j in range(3)] for i in range(3)]
    V = [[ca.SX(float(i == j)) for j in range(3)] for i in range(3)]
    for p, q in [(0, 1), (0, 2), (1, 2)] * _SWEEPS:
        r, apart, twice = 3 - p - q, A[q][q] - A[p][p], 2.0 * A[p][q]
        root = ca.sqrt(apart * apart + twice * twice)
        t = twice / (ca.fabs(apart) + root + _LEAST)
        t = ca.if_else(apart < 0.0, -t, t)
        c = 1.0 / ca.sqrt(1.0 + t * t)
        s = t * c
        A[p][p], A[q][q] = A[p][p] - t * A[p][q], A[q][q] + t * A[p][q]
        A[p][q] = A[q][p] = ca.SX(0.0)
        first, second = c * A[r][p] - s * A[r][q], s * A[r][p] + c * A[r][q]
        A[r][p] = A[p][r] = first
        A[r][q] = A[q][r] = second
        for row in V:
            row[p], row[q] = c * row[p] - s * row[q], s * row[p] + c * row[q]
    return Eigen([A[i][i] for i in range(3)], V)


def largest_in_ball(basis: Eigen, b: ca.SX) -> Extreme:
    """Largest value over the unit ball, and never less than it."""
    eigenvalues, V = ca.vertcat(*basis.values), ca.vertcat(*(ca.horzcat(*row) for row in basis.vectors))
    beta = 0.5 * ca.mtimes(V.T, b)
    top, ends = _most(basis.values), eigenvalues + ca.fabs(beta)
    size = _most(ca.vertsplit(ca.fabs(eigenvalues))) + ca.sum1(ca.fabs(beta))
    # No term of |s|^2 may exceed 1, so that mu is at least each lambda_i + |beta_i|.
    mu = least = _most([top + _TINY * size + _LEAST, ca.SX(0.0), *ca.vertsplit(ends)])
    for _ in range(_NEWTON):
        inverse = 1.0 / (mu - eigenvalues)
        terms = (beta * inverse) ** 2
        square, bend = ca.sum1(terms), ca.sum1(terms * inverse)
        # 1/|s| is concave in mu: from the left of the root Newton's steps stay left of it.
        mu = ca.fmax(mu + (ca.sqrt(square) - 1.0) * square / (bend + _LEAST), least)
    s = beta / (mu - eigenvalues)
    value = mu + ca.dot(beta, s)
    place = _onto_sphere(ca.vertsplit(s), [value >= top for value in basis.values], mu > 0.0)
    return Extreme(value, ca.vertsplit(ca.mtimes(V, ca.vertcat(*place))))


def _onto_sphere(s: list[ca.SX], largest: list[ca.SX], outside: ca.SX) -> list[ca.SX]:
    """Where the largest value is taken: on the sphere unless mu is 0.

    In the hard case s is too short, and the direction of the largest eigenvalue makes up for what it lacks.
    """
    free = outside
    for i in range(3):
        at_largest = ca.logic_and(free, largest[i])
        lacking = ca.sqrt(ca.fmax(1.0 - sum(s[j] ** 2 for j in range(3) if j != i), 0.0))
        s = [*s[:i], ca.if_else(at_largest, ca.if_else(s[i] < 0.0, -lacking, lacking), s[i]), *s[i + 1 :]]
        free = ca.logic_and(free, ca.logic_not(largest[i]))
    length = ca.sqrt(sum(x * x for x in s))
    return [ca.if_else(outside, x / (length + _LEAST), x) for x in s]


def largest_in_cube(Q: ca.SX, b: ca.SX) -> Extreme:
    """Largest value over |s_i| <= 1, from the stationary points of inside, faces, edges, and the corners."""
    value, place = ca.SX(-ca.inf), [ca.SX(0.0)] * 3
    for pattern in product((-1.0, 1.0, 0.0), repeat=3):
        s = [ca.SX(side) for side in pattern]
        free, fixed = ([i for i in range(3) if (pattern[i] == 0.0) == inside] for inside in (True, False))
        slopes = [-0.5 * b[i] - sum(pattern[j] * Q[i, j] for j in fixed) for i in free]
        for i, x in zip(free, _solution(Q[free, free], slopes), strict=True):
            s[i] = ca.fmin(ca.fmax(x, -1.0), 1.0)
        here = sum(s[i] * (b[i] + sum(Q[i, j] * s[j] for j in range(3))) for i in range(3))
        better = here > value
        value = ca.if_else(better, here, value)
        place = [ca.if_else(better, new, old) for new, old in zip(s, place, strict=True)]
    return Extreme(value, place)


def _solution(A: ca.SX, y: list[ca.SX]) -> list[ca.SX]:
    """Solution of up to three equations by cofactors; 0 where there is none or many.

    Along the directions of a singular system the quadratic is linear, so that its largest value over the cube is
    taken on a smaller face too.
    """
    if not y:
        return []
    adjugate = ca.adj(A) if len(y) > 1 else ca.SX(1.0)
    determinant = ca.mtimes(A[0, :], adjugate[:, 0])
    return [
        ca.if_else(determinant == 0.0, 0.0, value / determinant)
        for value in ca.vertsplit(ca.mtimes(adjugate, ca.vertcat(*y)))
    ]


def _most(values: list[ca.SX]) -> ca.SX:
    largest = values[0]
    for value in values[1:]:
        largest = ca.fmax(largest, value)
    return largest
