"""`result.plot()`: the one place from which the pictures, and matplotlib, are loaded."""

from __future__ import annotations

from typing import Any


def draw(result: object, ax: Any = None, **options: Any) -> Any:
    """Draw a result as `jounce.plots` draws its kind, which is loaded here when first asked for.

    Parameters
    ----------
    result : object
        A trajectory, a survey, margins, …
    ax : Axes, optional
        To draw in, for pictures of one panel. Default: pyplot's current ones.
    **options
        Those of the function in `jounce.plots` for this kind of result.

    Returns
    -------
    Axes or Figure

    Raises
    ------
    TypeError
        For a result of a kind that has no picture.
    """
    from ..plots import draw as picture

    return picture(result, ax, **options)
