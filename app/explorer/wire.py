"""Parts on their way to a page: plain data as JSON, arrays behind it as single-precision bytes."""

from __future__ import annotations

import json
from collections.abc import Mapping
from math import isfinite
from typing import Any

import numpy as np

ARRAY = "$array"
"""Key of what stands for an array in plain data: its number among the buffers."""


def packed(part: Mapping[str, Any]) -> tuple[dict[str, Any], list[bytes]]:
    """Return a part as plain data and buffers of its arrays, little-endian float32.

    Numbers that are not finite are None.
    """
    buffers: list[bytes] = []
    plain: dict[str, Any] = _plain(part, buffers)
    return plain, buffers


def framed(part: Mapping[str, Any]) -> bytes:
    """Return a part as one message: length of the JSON (4 bytes), the JSON, the buffers."""
    plain, buffers = packed(part)
    head = json.dumps([plain, [len(buffer) for buffer in buffers]], allow_nan=False).encode()
    head += b" " * (-len(head) % 4)
    return b"".join([len(head).to_bytes(4, "little"), head, *buffers])


def _plain(value: Any, buffers: list[bytes]) -> Any:
    if isinstance(value, np.ndarray):
        buffers.append(np.ascontiguousarray(value, dtype="<f4").tobytes())
        return {ARRAY: len(buffers) - 1}
    if isinstance(value, Mapping):
        return {key: _plain(each, buffers) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each, buffers) for each in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not isfinite(value) else value
