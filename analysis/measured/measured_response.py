"""The noun: a frequency response that was measured, with its error bars and what it is of."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from ...shaping.checks import one_of, positive, whole
from ...shaping.drawing import draw
from ...shaping.frozen import Frozen
from ...shaping.real_numbers import shown
from ...shaping.told import Rows, Told
from .local_fits import LEAST_LINES, LocalFits, local_fits
from .rational_fits import Complex, Real

if TYPE_CHECKING:
    import control

Kind = Literal["plant", "loop", "sensitivity", "process-sensitivity", "complementary"]
"""What a response is of: G = y/u, L = C·G, S = u/w, PS = y/w or T = L·S."""

KINDS: tuple[str, ...] = get_args(Kind)

MOST_LINES = 200_000
_MOST_INTEGRATORS = 6


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredResponse(Told, Frozen):
    """A measured frequency response: lines, complex values and their standard deviations.

    With u the plant's input as it is sent, y its output as it is read, w an excitation added to
    u and e = −y: u = C·e + w, L = C·G, S = 1/(1 + L) = u/w. Of sampled signals it is the
    response of the plant behind its hold, computing delay included.

    Parameters
    ----------
    frequency_hz : (N,) array
        Positive and ascending; 8 lines or more, 200,000 at the most.
    response : (N,) complex array
    sigma : (N,) array, optional
        Complex standard deviations √E|dG|², so that the real part has σ/√2. Default: none were
        measured; what needs them estimates them from how far lines are off smooth curves.
    kind : "plant", "loop", "sensitivity", "process-sensitivity" or "complementary"
        What it is a response of.
    dt : float, optional
        Sample time in seconds of the signals. Default: unknown, or continuous.
    integrators : int, optional
        Of the plant where that or PS was measured: 2 of a mass that is free, 1 of one with viscous
        friction; of the whole loop else. Default: read off the slope and phase of the lowest lines.
    unstable_poles : int, optional
        Of the plant, in the right half plane. Default: unknown, which is taken for none and said.

    Raises
    ------
    ValueError
        For arrays of unequal length, lines that repeat, fall or are not positive, values that
        are not finite, lines above half the sampling frequency.

    Examples
    --------
    >>> lines = np.arange(1.0, 50.0)
    >>> MeasuredResponse(lines, 1 / (2j * np.pi * lines), kind="loop")
    MeasuredResponse(loop, 49 lines, 1 to 49 Hz)
    """

    frequency_hz: Real
    response: Complex
    sigma: Real | None = None
    _: KW_ONLY
    kind: Kind
    dt: float | None = None
    integrators: int | None = None
    unstable_poles: int | None = None

    def __post_init__(self) -> None:
        one_of("kind", self.kind, KINDS)
        lines = _numbers("frequency_hz", self.frequency_hz, float)
        values = _numbers("response", self.response, complex)
        sigma = None if self.sigma is None else _numbers("sigma", self.sigma, float)
        _check_lengths(lines, values, sigma)
        _check_lines(lines)
        _check_finite("response", values, lines)
        if not values.any():
            raise ValueError(
                "response is 0 on every line: expected a measurement; check the channel"
            )
        if sigma is not None:
            _check_finite("sigma", sigma, lines)
            if (sigma < 0.0).any():
                at = int(np.argmax(sigma < 0.0))
                raise ValueError(
                    f"sigma = {sigma[at]:g} at {lines[at]:g} Hz: expected standard deviations, "
                    "0 or more"
                )
        if self.dt is not None:
            object.__setattr__(self, "dt", positive("dt", self.dt))
            _check_nyquist(lines, self.dt)
        for name in ("integrators", "unstable_poles"):
            count = getattr(self, name)
            if count is not None:
                object.__setattr__(self, name, whole(name, count, 0, _MOST_INTEGRATORS))
        for name, array in (("frequency_hz", lines), ("response", values), ("sigma", sigma)):
            object.__setattr__(self, name, array)
        super().__post_init__()

    @classmethod
    def from_frd(
        cls,
        frd: control.FrequencyResponseData,
        *,
        kind: Kind,
        sigma: ArrayLike | None = None,
        integrators: int | None = None,
        unstable_poles: int | None = None,
    ) -> MeasuredResponse:
        """Return python-control's frequency response data, one input and output; DC is left out."""
        if not is_frd(frd):
            raise TypeError(
                f"frd is a {type(frd).__name__}: expected a control.FrequencyResponseData; make "
                "one with control.frd(response, omega)"
            )
        if (frd.noutputs, frd.ninputs) != (1, 1):
            raise ValueError(
                f"frd has {frd.ninputs} inputs and {frd.noutputs} outputs: expected one of each; "
                "pick a channel with frd[i, j]"
            )
        order = np.argsort(frd.omega, kind="stable")
        order = order[np.asarray(frd.omega)[order] > 0.0]
        bars = None if sigma is None else _numbers("sigma", sigma, float)
        if bars is not None and len(bars) != len(frd.omega):
            raise ValueError(f"sigma has {len(bars)} values for {len(frd.omega)} lines of frd")
        return cls(
            np.asarray(frd.omega)[order] / (2.0 * np.pi),
            np.asarray(frd.frdata)[0, 0, order],
            None if bars is None else bars[order],
            kind=kind,
            dt=float(frd.dt) if frd.dt and frd.dt is not True else None,
            integrators=integrators,
            unstable_poles=unstable_poles,
        )

    def to_frd(self) -> control.FrequencyResponseData:
        """Return it as python-control's frequency response data; the error bars are left out."""
        import control

        omega = 2.0 * np.pi * self.frequency_hz
        return control.frd(self.response, omega, 0 if self.dt is None else self.dt)

    @cached_property
    def fits(self) -> LocalFits:
        """Rational fits around the gaps between its lines."""
        return local_fits(self.frequency_hz, self.response, self.sigma)

    def plot(self, ax: Any = None, **options: Any) -> Any:
        """Draw it by `jounce.plots`; with controller=… the loop that it closes."""
        return draw(self, ax, **options)

    def table_rows(self) -> Rows:
        """Return kind, lines and range."""
        yield "kind", self.kind
        yield "lines", len(self.frequency_hz)
        yield "frequencies", f"{self.frequency_hz[0]:.5g} … {self.frequency_hz[-1]:.5g} Hz"

    def __repr__(self) -> str:
        low, high = self.frequency_hz[[0, -1]]
        return (
            f"MeasuredResponse({self.kind}, {len(self.frequency_hz)} lines, "
            f"{low:.6g} to {high:.6g} Hz)"
        )


def is_frd(system: Any) -> bool:
    """Whether something is python-control's frequency response data."""
    return hasattr(system, "frdata") and hasattr(system, "omega")


def as_measured(given: Any, *, plant: bool) -> MeasuredResponse:
    """Return a measured response; python-control's data become one of a plant, or of a loop.

    Raises
    ------
    TypeError
        For anything else.
    """
    if isinstance(given, MeasuredResponse):
        return given
    if is_frd(given):
        return MeasuredResponse.from_frd(given, kind="plant" if plant else "loop")
    raise TypeError(
        f"measured = {shown(given)}: expected a MeasuredResponse or a "
        f"control.FrequencyResponseData; read a file by read_frf(path, kind=…)"
    )


def _numbers(name: str, given: Any, kind: type) -> Any:
    try:
        array = np.array(given)
        if np.iscomplexobj(array) and kind is float:
            raise TypeError
        array = array.astype(kind)
    except (TypeError, ValueError):
        word = "real" if kind is float else "complex"
        raise TypeError(f"{name} = {shown(given)}: expected an array of {word} numbers") from None
    if array.ndim != 1:
        raise ValueError(f"{name} of shape {array.shape}: expected one dimension, (N,)")
    return array


def _check_lengths(lines: Real, values: Complex, sigma: Real | None) -> None:
    named = {"response": values} | ({} if sigma is None else {"sigma": sigma})
    for name, array in named.items():
        if len(array) != len(lines):
            raise ValueError(
                f"{name} has {len(array)} values for {len(lines)} frequencies: expected as many; "
                "cut the longer one"
            )
    if not LEAST_LINES <= len(lines) <= MOST_LINES:
        remedy = (
            "measure more lines"
            if len(lines) < LEAST_LINES
            else "average neighbouring lines, or leave out what lies far above the crossover"
        )
        raise ValueError(
            f"a response of {len(lines)} {'line' if len(lines) == 1 else 'lines'}: expected "
            f"{LEAST_LINES} to {MOST_LINES}; {remedy}"
        )


def _check_lines(lines: Real) -> None:
    _check_finite("frequency_hz", lines, np.arange(1.0, 1.0 + len(lines)), "line number")
    if lines[0] <= 0.0:
        raise ValueError(
            f"frequency_hz begins at {lines[0]:g}: expected positive frequencies; leave DC out"
        )
    steps = np.diff(lines)
    if (steps <= 0.0).any():
        at = int(np.argmax(steps <= 0.0))
        if steps[at] == 0.0:
            raise ValueError(
                f"frequency {lines[at]:g} Hz is there twice: expected ascending frequencies; "
                "average the repeated lines, or give each measurement on its own"
            )
        raise ValueError(
            f"frequency falls from {lines[at]:g} to {lines[at + 1]:g} Hz: expected ascending "
            "frequencies; sort the lines, or give each measurement on its own"
        )


def _check_finite(name: str, values: Any, lines: Real, where: str = "Hz") -> None:
    bad = ~np.isfinite(values)
    if bad.any():
        at = int(np.argmax(bad))
        place = f"{lines[at]:g} Hz" if where == "Hz" else f"{where} {at + 1}"
        raise ValueError(
            f"{name} = {values[at]} at {place}: expected finite numbers; leave the line out"
        )


def _check_nyquist(lines: Real, dt: float) -> None:
    if lines[-1] > 0.5 / dt * (1.0 + 1e-9):
        raise ValueError(
            f"frequency {lines[-1]:g} Hz is above half the sampling frequency, {0.5 / dt:g} Hz of "
            f"dt = {dt:g}: leave those lines out, or see that frequencies are in Hz"
        )
