"""What options of `jounce fmu` mean: durations, sizes, files, values of --set."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..fmu.cosimulation.ssp_plan import SspPlan
    from ..fmu.importing.description import FmuDescription, FmuVariable

_SIZE = re.compile(r"([0-9]+(?:\.[0-9]*)?)\s*(|[kMGT]?B|[KMGT]iB)", re.ASCII)
_SIZES = {"": 1, "B": 1, "kB": 10**3, "MB": 10**6, "GB": 10**9, "TB": 10**12} | {
    "KiB": 2**10, "MiB": 2**20, "GiB": 2**30, "TiB": 2**40
}  # fmt: skip
_DOUBLES = ("Real", "Float64", "Float32")


def seconds(option: str, text: str) -> float:
    """Return a duration given as a number of seconds, or with its unit."""
    from .units import DURATION, UnitError, parse_quantity

    try:
        value = float(text)
    except ValueError:
        try:
            return parse_quantity(text, DURATION)
        except UnitError as error:
            raise ValueError(f"{option}: {error}") from None
    if not 0.0 < value < math.inf:
        raise ValueError(f"{option} {text!r}: expected a positive duration, such as '2 ms'")
    return value


def size_in_bytes(option: str, text: str) -> int:
    """Return a size given as a number of bytes, or with its unit."""
    found = _SIZE.fullmatch(text.strip())
    size = round(float(found[1]) * _SIZES[found[2]]) if found else 0
    if size < 1:
        raise ValueError(f"{option} {text!r}: expected a number of bytes, such as '4 GB'")
    return size


def is_ssp(file: Path) -> bool:
    """Whether a file or folder is a system of FMUs, by its name or what is in it."""
    return file.suffix.lower() == ".ssp" or (file / "SystemStructure.ssd").is_file()


def check_readable(file: Path) -> None:
    """Refuse what is not there, and folders of something else."""
    from ..fmu.importing.unpacking import HEADS

    if not file.exists():
        raise ValueError(f"{file}: is not there; give the path of an FMU or an SSP")
    if file.is_dir() and not any((file / name).is_file() for name in HEADS):
        raise ValueError(
            f"{file}: a folder without a {' or '.join(HEADS)}, which an unpacked FMU or SSP has; "
            "give the path of one"
        )


def check_files(file: Path, given: Mapping[str, Path | None], inputs: Path | None) -> None:
    """Refuse, before anything is run, files to be written that cannot be what they are to be."""
    from .result_files import check_picture

    written: dict[Path, str] = {}
    for option, path in given.items():
        if path is None:
            continue
        if option == "--plot":
            check_picture(path)
        whole = path.resolve()
        if not whole.parent.is_dir():
            raise ValueError(
                f"{option} {path}: No such file or directory as {path.parent}, to write into; make "
                "it, or name another"
            )
        if whole == file.resolve():
            raise ValueError(f"{option} {path}: is the FMU that is run; name another file")
        if inputs is not None and whole == inputs.resolve():
            raise ValueError(f"{option} {path}: is the file of --input; name another file")
        if whole in written:
            raise ValueError(f"{written[whole]} and {option} are both {path}: name two files")
        written[whole] = option


def settings_of(description: FmuDescription, texts: Sequence[str]) -> dict[str, object]:
    """Return what --set says, by name, each value as the FMU declares it."""
    return dict(_setting(description, text, *_parted(text)) for text in texts)


def settings_within(plan: SspPlan, texts: Sequence[str]) -> dict[str, object]:
    """Return what --set says of a system: "component.variable", its inputs and parameters."""
    found: dict[str, object] = {}
    for text in texts:
        name, value = _parted(text)
        block, _, own = name.partition(".")
        if name in plan.of_system:
            found[name] = _number(value, f"--set {text!r}: expected a number")
        elif block in plan.descriptions:
            found[name] = _setting(plan.descriptions[block], text, own, value)[1]
        else:
            found[name] = value  # which names nothing: load_ssp tells what there is
    return found


def _parted(text: str) -> tuple[str, str]:
    name, separator, value = text.partition("=")
    if not separator or not name.strip():
        raise ValueError(f"--set {text!r}: expected NAME=VALUE, such as --set u=1.5")
    return name.strip(), value.strip()


def _setting(description: FmuDescription, text: str, name: str, value: str) -> tuple[str, object]:
    variable, place = description.element(name)
    if place is not None or not variable.shape:
        return name, _value(variable, text, value, "a number")
    parts = value.split(",")
    wanted = f"{variable.size} numbers, separated by commas"
    if len(parts) != variable.size:
        raise ValueError(f"--set {text!r}: expected {wanted}{_unit(variable)}")
    return name, [_value(variable, text, part.strip(), wanted) for part in parts]


def _value(variable: FmuVariable, text: str, value: str, wanted: str) -> object:
    """Return one value from its text."""
    if variable.type == "String":
        return value
    if variable.type == "Boolean":
        if value.lower() not in ("true", "false", "1", "0"):
            raise ValueError(f"--set {text!r}: {variable.name} is true or false")
        return value.lower() in ("true", "1")
    if variable.type == "Binary":
        try:
            return bytes.fromhex(value)
        except ValueError:
            raise ValueError(f"--set {text!r}: expected hexadecimal digits, two a byte") from None
    error = f"--set {text!r}: expected {wanted}{_unit(variable)}"
    if variable.type in _DOUBLES:
        return _number(value, error)
    try:
        return int(value)  # which may have more digits than a double
    except ValueError:
        if variable.type == "Enumeration":
            return value
        return _number(value, error)


def _number(value: str, error: str) -> float:
    try:
        number = float(value)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise ValueError(error)
    return number


def _unit(variable: FmuVariable) -> str:
    return f", in {variable.unit}" if variable.unit not in ("", "1") else ""
