"""Cases of measured loops, run from plain parameters through the public names of the library."""

import json
from pathlib import Path

import control

from jounce.analysis import estimate_frf, loop_margins, read_frf
from jounce.analysis.measured import MeasuredResponse

LEFT_OUT = ("dt", "reasons", "warnings", "stable")


def run_case(entry, folder):
    """Return stable, reasons, warnings and each margin that can be told with its `_sigma`.

    Parameters
    ----------
    entry : mapping
        With "file" and "kind", or "record"; where they are known controller_file, averages,
        plant_integrators, plant_unstable_poles.
    folder : path
        Of the files.
    """
    folder = Path(folder)
    controller, dt = None, None
    if "controller_file" in entry:
        controller, dt = read_controller(folder / entry["controller_file"])
    response = response_of(entry, folder, dt)
    if response.kind not in ("plant", "process-sensitivity"):
        controller = None  # it was measured with the plant
    margins = loop_margins(response, controller=controller)
    told = {
        name: value
        for name, value in margins.as_dict().items()
        if name not in LEFT_OUT and value is not None
    }
    return {
        "stable": margins.stable,
        "reasons": list(margins.reasons),
        "warnings": list(margins.warnings),
        **told,
    }


def response_of(entry, folder, dt):
    """Return the measured response of a case; what is declared is the plant's."""
    kind = entry.get("kind", "plant")
    of_plant = kind in ("plant", "process-sensitivity")
    declared = {
        "integrators": entry.get("plant_integrators") if of_plant else None,
        "unstable_poles": entry.get("plant_unstable_poles"),
    }
    if "file" not in entry:
        return estimated(folder / entry["record"].split(":")[0].strip(), declared)
    others = {
        name: entry[name] for name in ("output", "columns", "frequency_unit") if name in entry
    }
    return read_frf(
        folder / entry["file"],
        kind=kind,
        averages=entry.get("averages"),
        dt=dt,
        **declared,
        **others,
    )


def estimated(path, declared):
    """Return the plant of a record: fs, N, w (one period or all), u and y."""
    from scipy.io import loadmat

    record = loadmat(path, simplify_cells=True)
    found = estimate_frf(
        record["w"], record["u"], record["y"], 1.0 / float(record["fs"]), period=int(record["N"])
    )
    plant = found.plant
    return MeasuredResponse(
        plant.frequency_hz, plant.response, plant.sigma, kind="plant", dt=plant.dt, **declared
    )


def read_controller(path):
    """Return a controller given as sections of polynomials in z, in series, and its sample time."""
    content = json.loads(Path(path).read_text(encoding="utf-8"))
    dt = 1.0 / content["sample_rate_hz"]
    sections = [control.ss(control.tf(s["b"], s["a"], dt)) for s in content["sections"]]
    whole = sections[0]
    for section in sections[1:]:
        whole = control.series(whole, section)
    return whole, dt
