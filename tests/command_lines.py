"""What the tests of commands have in common."""

from pathlib import Path

UNSTABLE = """
plant.inertia = "1 kg m^2"
controller.gains = {kp = "28 N m/rad", ki = "38 N m/(rad s)", kr = "1 N m s/rad"}
limits.axis = {acceleration = "0.2 deg/s^2"}
moves = [{name = "go", distance = "60 arcsec", settle_to = "50 mas"}]
"""


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def refused(run, folder: Path, *arguments: object) -> str:
    """Return the one line of a refusal that printed and wrote nothing else."""
    before = names(folder)
    status, out, errors = run(*arguments)
    assert (status, out) == (2, "")
    (line,) = errors
    assert line.startswith("jounce: ")
    assert names(folder) == before
    return line
