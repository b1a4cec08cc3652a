"""Poles of a closed loop with a pure delay, which is not approximated."""

import numpy as np

from .factored_loop import Complex, FactoredLoop

_TURN = 2 * np.pi
_TOUCHING = 1e-6
_NODES = 24
_MOST_NODES = 240
_APART, _STILL = 1e-8, 1e-12


def rightmost_poles(loop: FactoredLoop, near: Complex) -> Complex:
    """Return closed-loop poles in rad/s, the slowest decay first: those found to rounding.

    Beside `near`, scaled places near which poles may lie, such as passages of L through −1,
    the delay is a transport equation, discretised on Chebyshev points (Breda, Maset and
    Vermiglio, SIAM J. Sci. Comput. 27 (2005) 482-495); what its eigenvalues say is corrected by
    Newton steps on 1 + L(s) itself.
    """
    found = [
        _corrected(loop, np.concatenate([_of_transport(loop), near, near.conj()])),
        _unmoved(loop),
        loop.hidden,
    ]
    poles = np.concatenate(found) * loop.scale
    return np.asarray(poles[np.argsort(-poles.real, kind="stable")])


def _unmoved(loop: FactoredLoop) -> Complex:
    """Return the poles of L that the feedback does not move, or by no more than rounding.

    Zeros cancel them, or they are so fast and unstable that nothing comes back in time.
    """
    nearest = [
        abs(loop.poles[:, None] - roots).min(axis=1, initial=np.inf)
        for roots in (loop.zeros, loop.closed)
    ]
    cancelled = np.maximum(*nearest) <= _APART * abs(loop.poles)
    gaps = loop.poles[:, None] - loop.poles + np.eye(loop.poles.size)
    with np.errstate(all="ignore"):
        residues = (loop.poles[:, None] - loop.zeros).prod(axis=1) / gaps.prod(axis=1)
        shifts = abs(loop.gain * residues * np.exp(-loop.poles * loop.delay))
        return np.asarray(loop.poles[cancelled | (shifts <= _STILL * abs(loop.poles))])


def _of_transport(loop: FactoredLoop) -> Complex:
    """Return the eigenvalues of the loop with its delay discretised."""
    n = loop.poles.size
    speed = loop.delay * float(abs(loop.closed).max(initial=1.0))
    nodes = int(min(_NODES + 2 * speed, _MOST_NODES))
    points = np.cos(np.pi * np.arange(nodes + 1) / nodes)
    weights = np.r_[2.0, np.ones(nodes - 1), 2.0] * (-1.0) ** np.arange(nodes + 1)
    gaps = points[:, None] - points + np.eye(nodes + 1)
    transport = np.outer(weights, 1.0 / weights) / gaps
    transport -= np.diag(transport.sum(axis=1))
    transport *= 2.0 / loop.delay
    numerator = loop.gain * np.real(np.poly(loop.zeros)) * np.ones(1)
    denominator = np.real(np.poly(loop.poles)) * np.ones(1)
    padded = np.concatenate([np.zeros(n + 1 - numerator.size), numerator])
    direct = padded[0]
    out = padded[1:] - direct * denominator[1:]
    # States of the loop, then its input along the delay; the newest is −(out·x + direct·oldest).
    matrix = np.zeros((n + nodes, n + nodes))
    matrix[:n, :n] = np.diag(np.ones(max(n - 1, 0)), -1)[:n, :n]
    matrix[0, :n] = -denominator[1:]
    matrix[0, -1] = 1.0
    newest = np.concatenate([-out, np.zeros(nodes - 1), [-direct]])
    matrix[n:, n:] = transport[1:, 1:]
    matrix[n:] += np.outer(transport[1:, 0], newest)
    return np.linalg.eigvals(matrix).astype(complex)


def _corrected(loop: FactoredLoop, poles: Complex) -> Complex:
    """Return the roots of 1 + L(s) that Newton steps reach from estimates, each once."""
    with np.errstate(all="ignore"):
        for _ in range(8):
            value = loop.at(poles)
            slope = (1 / (poles[:, None] - loop.zeros)).sum(axis=1) - loop.delay
            slope = slope - (1 / (poles[:, None] - loop.poles)).sum(axis=1)
            step = np.log(-value) / slope
            poles = poles - step
        settled = np.isfinite(poles) & (abs(step) <= 1e-10 * abs(poles))
    poles = poles[settled & (abs(1 + loop.at(poles)) < 0.1)]
    poles = poles[np.lexsort((poles.imag, -poles.real))]
    kept: list[complex] = []
    for pole in poles.tolist():
        if all(abs(pole - other) > _APART * abs(pole) for other in kept):
            kept.append(pole)
    return np.array(kept, dtype=complex)
