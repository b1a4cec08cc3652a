"""Linear models as bare numbers, of which poles, zeros and responses are known without a library.

They answer by the names that python-control's systems have, so that whatever reads a loop's
frequency response, poles and coefficients takes either.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..shaping.pieces import FloatArray

Complex = NDArray[np.complex128]

_FAR = 1e-13  # of the largest: the inverse of a zero that is infinite


@dataclass(frozen=True, eq=False)
class StateModel:
    """ẋ = A·x + B·u, or x_{k+1} with a sampling time dt > 0; y = C·x + D·u."""

    A: FloatArray
    B: FloatArray
    C: FloatArray
    D: FloatArray
    dt: float = 0.0

    @classmethod
    def of(cls, system: Any) -> StateModel:
        """Return the numbers of a system in state space."""
        a, b, c, d = (np.asarray(getattr(system, name)) for name in "ABCD")
        return cls(a, b, c, d, system.dt or 0.0)

    @property
    def nstates(self) -> int:
        """Number of states."""
        return len(self.A)

    @property
    def ninputs(self) -> int:
        """Number of inputs."""
        return int(self.B.shape[1])

    @property
    def noutputs(self) -> int:
        """Number of outputs."""
        return len(self.C)

    def isdtime(self, strict: bool = False) -> bool:  # noqa: ARG002 - the time base is known
        """Return whether it has a sampling time."""
        return self.dt > 0.0

    def poles(self) -> Complex:
        """Return the eigenvalues of A."""
        return np.linalg.eigvals(self.A).astype(complex)

    def zeros(self) -> Complex:
        """Return the finite zeros of a model with one input and one output.

        With M(s) = [[A − s, B], [C, D]] they are s₀ + 1/μ, μ the eigenvalues of M(s₀)⁻¹·diag(1, 0).
        """
        n = self.nstates
        place = 1.618 * (1.0 + abs(self.A).max(initial=0.0))
        matrix = np.block([[self.A - place * np.eye(n), self.B], [self.C, self.D]])
        with np.errstate(all="ignore"):
            inverse = np.linalg.eigvals(np.linalg.solve(matrix, np.eye(n + 1, n)[:, :n])[:n])
        finite = inverse[abs(inverse) > _FAR * abs(inverse).max(initial=0.0)]
        return np.asarray(place + 1.0 / finite, dtype=complex)

    def __call__(self, s: ArrayLike) -> Any:
        """Return D + C·(s − A)⁻¹·B at points, of a model with one input and one output."""
        values = self.at(np.atleast_1d(np.asarray(s, dtype=complex)).ravel())[:, 0, 0]
        return values[0] if np.ndim(s) == 0 else values.reshape(np.shape(s))

    def at(self, points: Complex) -> Complex:
        """Return the same at points (N,) of any model, (N, outputs, inputs)."""
        matrices = points[:, None, None] * np.eye(self.nstates) - self.A
        states = np.linalg.solve(matrices, np.broadcast_to(self.B, (len(points), *self.B.shape)))
        return np.asarray(self.C @ states + self.D)

    def __rmul__(self, gain: float) -> StateModel:
        return StateModel(self.A, self.B, gain * self.C, gain * self.D, self.dt)

    def feedback(self) -> StateModel:
        """Return the closed loop of a model with one input and one output."""
        share = 1.0 / (1.0 + self.D[0, 0])
        a = self.A - share * self.B @ self.C
        return StateModel(a, share * self.B, share * self.C, share * self.D, self.dt)

    def behind(self, first: StateModel) -> StateModel:
        """Return this one behind another, whose states come first."""
        corner = np.zeros((first.nstates, self.nstates))
        return StateModel(
            np.block([[first.A, corner], [self.B @ first.C, self.A]]),
            np.vstack([first.B, self.B @ first.D]),
            np.hstack([self.D @ first.C, self.C]),
            self.D @ first.D,
            self.dt,
        )


@dataclass(frozen=True, eq=False)
class Rational:
    """A quotient of polynomials in s, highest power first, improper ones included."""

    numerator: FloatArray
    denominator: FloatArray
    dt = 0.0
    ninputs = noutputs = 1

    @property
    def num_array(self) -> NDArray[np.object_]:
        """Numerators by output and input."""
        return _boxed(self.numerator)

    @property
    def den_array(self) -> NDArray[np.object_]:
        """Denominators by output and input."""
        return _boxed(self.denominator)

    def isdtime(self, strict: bool = False) -> bool:  # noqa: ARG002 - it never is
        """Return False: it is continuous."""
        return False

    def poles(self) -> Complex:
        """Return the roots of the denominator."""
        return np.roots(self.denominator).astype(complex)

    def zeros(self) -> Complex:
        """Return the roots of the numerator."""
        return np.roots(self.numerator).astype(complex)

    def __call__(self, s: ArrayLike) -> Any:
        """Return its values at points."""
        points = np.asarray(s, dtype=complex)
        return _value(self.numerator, points) / _value(self.denominator, points)

    def __rmul__(self, gain: float) -> Rational:
        return Rational(gain * self.numerator, self.denominator)

    def feedback(self) -> Rational:
        """Return the closed loop."""
        return Rational(self.numerator, np.asarray(np.polyadd(self.denominator, self.numerator)))


def _value(polynomial: FloatArray, points: Complex) -> Any:
    return np.polyval(polynomial.astype(complex), points)


def _boxed(polynomial: FloatArray) -> NDArray[np.object_]:
    box = np.empty((1, 1), dtype=object)
    box[0, 0] = polynomial
    return box
