"""Loops in exact arithmetic: crossovers, closed-loop poles, poles counted behind a delay."""

from fractions import Fraction

import mpmath
import numpy as np


def times(left, right):
    product = [Fraction(0)] * (len(left) + len(right) - 1)
    for i, a in enumerate(left):
        for j, b in enumerate(right):
            product[i + j] += Fraction(float(a)) * Fraction(float(b))
    return product


def plus(left, right, factor=1):
    size = max(len(left), len(right))
    padded = [[Fraction(0)] * (size - len(row)) + [Fraction(float(x)) for x in row]
              for row in (left, right)]  # fmt: skip
    return [a + factor * b for a, b in zip(*padded, strict=True)]


def roots(row):
    """Roots of a polynomial, the highest power first, to 40 digits."""
    coefficients = [mpmath.mpf(x.numerator) / x.denominator for x in row]
    while coefficients and coefficients[0] == 0:
        coefficients.pop(0)
    at_zero = 0
    while coefficients and coefficients[-1] == 0:
        coefficients.pop()
        at_zero += 1
    if len(coefficients) < 2:
        return [mpmath.mpf(0)] * at_zero
    with mpmath.workdps(40):
        found = mpmath.polyroots(coefficients[::-1], maxsteps=300, extraprec=300, asc=True)
    return [mpmath.mpf(0)] * at_zero + list(found)


def crossovers(num, den):
    """All ω > 0 with |N(jω)| = |D(jω)|: positive roots x = ω² of |N|² − |D|²."""
    squares = []
    for row in (num, den):
        turned = [x * (-1) ** (len(row) - 1 - i) for i, x in enumerate(row)]
        product = times(row, turned)[::2]  # P(s)·P(−s) in s² = −x
        power = len(product) - 1
        squares.append([x * (-1) ** (power - i) for i, x in enumerate(product)])
    found = [x for x in roots(plus(*squares, -1)) if abs(mpmath.im(x)) < 1e-18 * abs(x)]
    return sorted(float(mpmath.sqrt(mpmath.re(x))) for x in found if mpmath.re(x) > 0)


def closed_poles(num, den, factor=1.0, samples=0):
    """Roots of D·z^samples + factor·N."""
    return roots(plus([*den, *[0] * samples], num, Fraction(float(factor))))


def unstable_behind(num, den, delay):
    """How many roots of D + N·e^(−s·delay) lie on the right: Mikhailov's criterion, on a grid."""
    corners = abs(np.concatenate([np.roots(num), np.roots(den), [1.0]]))
    top = 1e3 * corners.max() * max(1.0, abs(np.array(num)).max() / abs(den[0]))
    near = min(top, 60 * corners.max())
    omega = np.unique(
        np.concatenate([
            [0.0],
            np.geomspace(1e-4 * corners[corners > 0].min(), top, 10_000),
            np.linspace(0, near, 10_000),
            np.arange(0, near, 0.3 / delay) if delay else [],
        ])
    )  # fmt: skip

    def value(omega):
        s = 1j * omega
        return np.polyval(den, s) + np.polyval(num, s) * np.exp(-s * delay)

    values = value(omega)
    for _ in range(60):
        turns = abs(np.angle(values[1:] / values[:-1]))
        [wide] = np.nonzero((turns > 0.4) & (np.diff(omega) > 1e-15 * omega[1:]))
        middle = 0.5 * (omega[wide] + omega[wide + 1])
        omega = np.insert(omega, wide + 1, middle)
        values = np.insert(values, wide + 1, value(middle))
    turned = np.angle(values[1:] / values[:-1]).sum() / np.pi
    return round(0.5 * (len(den) - 1) - turned)
