"""The command `jounce plan`: the fastest move between rests, or an S-curve."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from . import cli
from .common_options import AS_JSON, QUIET
from .printing import print_parts

if TYPE_CHECKING:
    from rich.table import Table

    from ..shaping import Certificate
    from ..shaping.plain_moves import Method
    from .plan import Plan


def plan_command(
    distance: Annotated[
        list[str] | None, cli.Argument(help='Such as "60 arcsec" or "-2 mm"; or give --to.')
    ] = None,
    velocity: Annotated[str | None, cli.Option(help='Such as "1 deg/s".')] = None,
    acceleration: Annotated[
        str | None,
        cli.Option(help='Such as "0.2 deg/s^2", or "-0.1 deg/s^2, 0.2 deg/s^2" for each way.'),
    ] = None,
    jerk: Annotated[str | None, cli.Option(help='Such as "2 deg/s^3".')] = None,
    snap: Annotated[str | None, cli.Option(help='Such as "20 deg/s^4".')] = None,
    crackle: Annotated[str | None, cli.Option(help='Such as "200 deg/s^5".')] = None,
    pop: Annotated[str | None, cli.Option(help='Such as "76.8 deg/s^6".')] = None,
    limit: Annotated[
        list[str] | None,
        cli.Option(help='Any derivative, such as "7=2e4 deg/s^7"; may be repeated.'),
    ] = None,
    position: Annotated[
        str | None, cli.Option(help='Lowest and highest position, such as "-4 mm, 4 mm".')
    ] = None,
    rise_time: Annotated[
        str | None,
        cli.Option(help="Rise time of the acceleration, in place of the highest limit."),
    ] = None,
    order: Annotated[
        str | None,
        cli.Option(metavar="INTEGER", help="Derivative that the rise time bounds: 6 for pop."),
    ] = None,
    start: Annotated[
        str | None, cli.Option("--from", "--start", help="Position at the start.")
    ] = None,
    to: Annotated[str | None, cli.Option(help="Position at the end, for a distance.")] = None,
    deceleration: Annotated[
        str | None,
        cli.Option(
            "--deceleration", "--decel", help="S-curve: largest acceleration while slowing down."
        ),
    ] = None,
    deceleration_jerk: Annotated[
        str | None, cli.Option(help="S-curve: largest jerk while slowing down.")
    ] = None,
    jerk_percent: Annotated[
        str | None,
        cli.Option(help='S-curve: share of each ramp with jerk, such as "50 %", for a jerk.'),
    ] = None,
    percent_keeps: Annotated[
        str | None,
        cli.Option(help="S-curve: what a jerk percent keeps, duration or acceleration."),
    ] = None,
    closed_form: Annotated[
        bool,
        cli.Option("--closed-form", help="From order 4 on: few pieces, but slower than need be."),
    ] = False,
    certify: Annotated[
        bool, cli.Option("--certify", help="Prove how near the move is to the minimum time.")
    ] = False,
    pieces: Annotated[
        bool, cli.Option("--pieces", help="Print the switch table from order 4 on, too.")
    ] = False,
    csv: Annotated[
        Path | None,
        cli.Option(help="Write the switch table to this file; one that is there is replaced."),
    ] = None,
    plot: Annotated[
        Path | None,
        cli.Option(
            help="Draw the move to this file (.png, .pdf, .svg); one that is there is replaced."
        ),
    ] = None,
    as_json: AS_JSON = False,
    _: QUIET = False,
) -> None:
    """Plan the fastest move between rests: its duration, its peaks and what limits them.

    With --deceleration, --deceleration-jerk or --jerk-percent it is an S-curve, as motion
    controllers have it.
    """
    from .plan import plan_move
    from .plan_report import plan_tables

    asked = _one_distance(distance or ())
    of_s_curve = {
        "deceleration": deceleration,
        "deceleration_jerk": deceleration_jerk,
        "jerk_percent": jerk_percent,
        "percent_keeps": percent_keeps,
    }
    if any(text is not None for text in of_s_curve.values()):
        from .plan_s_curve import SCurveText, plan_s_curve

        _refuse_beside_s_curve(
            {"--snap": snap, "--crackle": crackle, "--pop": pop, "--limit": limit}
            | {"--position": position}
            | {"--rise-time": rise_time, "--order": order, "--closed-form": closed_form}
            | {"--certify": certify}
        )
        rates = SCurveText(velocity, acceleration, jerk=jerk, **of_s_curve)
        plan = plan_s_curve(asked, rates, start=start, to=to)
    else:
        bounds = _bounds((velocity, acceleration, jerk, snap, crackle, pop), limit)
        method: Method = "closed-form" if closed_form else "optimal"
        bounded = None if order is None else _order(order)
        plan = plan_move(
            asked,
            bounds,
            start=start,
            to=to,
            position=position,
            rise_time=rise_time,
            order=bounded,
            method=method,
        )
    certificate = _certificate(plan) if certify else None
    proofs = _proofs(plan, certificate, closed_form=closed_form)
    if csv is not None or plot is not None:
        _write_plan(plan, csv, plot)
    if as_json:
        from .json_output import plan_data, print_json

        print_json(plan_data(plan, certificate))
        return
    print_parts(*plan_tables(plan, pieces=pieces), *proofs, *plan.remarks)
    for path in (csv, plot):
        if path is not None:
            print_parts(f"Wrote {path}")


def _certificate(plan: Plan) -> Certificate:
    from ..shaping import certify

    return certify(plan.trajectory, plan.limits)


def _proofs(plan: Plan, certificate: Certificate | None, *, closed_form: bool) -> list[Table | str]:
    from .plan_report import certificate_table, excess_text

    if certificate is not None:
        return [certificate_table(plan, certificate)]
    return [excess_text(plan)] if closed_form else []


def _one_distance(words: Sequence[str]) -> str | None:
    """Return the distance; ValueError where several words look like one."""
    if len(words) > 1:
        raise ValueError(
            f"unexpected {words[1]!r} behind the distance {words[0]!r}: write each quantity in "
            'quotation marks, such as "60 arcsec"'
        )
    return next(iter(words), None)


def _refuse_beside_s_curve(options: Mapping[str, object]) -> None:
    """Refuse options that say nothing about an S-curve."""
    given = next((name for name, value in options.items() if value), None)
    if given is not None:
        raise ValueError(
            f"{given} does not go with an S-curve, which --deceleration, --deceleration-jerk, "
            "--jerk-percent and --percent-keeps ask for: leave one or the other out"
        )


def _bounds(named: Sequence[str | None], limit: Sequence[str] | None) -> dict[int, str]:
    """Return the bounds by derivative, those with a name first."""
    bounds = {k: text for k, text in enumerate(named, start=1) if text is not None}
    for text in limit or ():
        k, quantity = _limit(text)
        if k in bounds:
            raise ValueError(f"--limit {text!r}: derivative {k} is already limited; give it once")
        bounds[k] = quantity
    return bounds


def _order(text: str) -> int:
    from .plan import derivative_key

    try:
        return derivative_key(text)
    except ValueError as error:
        raise ValueError(f"--order: {error}") from None


def _limit(text: str) -> tuple[int, str]:
    from .plan import derivative_key

    name, separator, quantity = text.partition("=")
    if not separator:
        raise ValueError(f'--limit {text!r}: expected DERIVATIVE=QUANTITY, such as "7=2e4 deg/s^7"')
    try:
        return derivative_key(name), quantity
    except ValueError as error:
        raise ValueError(f"--limit {text!r}: {error}") from None


def _write_plan(plan: Plan, csv: Path | None, plot: Path | None) -> None:
    from .plan_report import switch_rows
    from .result_files import check_picture, save_figure, write_files, write_rows

    writers: dict[Path, Callable[[Path], object]] = {}
    if csv is not None:
        header, rows = switch_rows(plan)
        writers[csv] = lambda draft: write_rows(draft, header, rows)
    if plot is not None:
        check_picture(plot)
        from matplotlib.figure import Figure

        from ..plots import plot_trajectory

        figure = plot_trajectory(
            plan.trajectory,
            limits=plan.limits,
            unit=plan.unit,
            scale=plan.scale,
            figure=Figure(),  # of its own, without pyplot and a display
        )
        writers[plot] = lambda draft: save_figure(figure, draft)
    write_files(writers)
