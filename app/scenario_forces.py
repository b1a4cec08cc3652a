"""Keys that name a force on a linear axis where others name a torque; both are taken."""

from __future__ import annotations

from dataclasses import fields
from typing import Any


def take_forces(section: Any, *names: str) -> None:
    """Move what the keys of a force say to those of a torque; refuse both together."""
    left_out = {field.name: field.default for field in fields(section)}
    for name in names:
        other = name.replace("torque", "force")
        given = getattr(section, other)
        if given is None:
            continue
        if getattr(section, name) != left_out[name]:
            raise ValueError(f"has {name} and {other}, which say the same; keep one")
        object.__setattr__(section, name, given)
        object.__setattr__(section, other, None)
