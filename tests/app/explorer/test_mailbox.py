"""Nothing queues: of many messages that wait all are taken, the last state alone is shown."""

import asyncio
import json

import numpy as np
import pytest
from explored import NOTCH, session_of, written

from jounce.app.explorer.mailbox import Mailbox
from jounce.app.explorer.wire import framed, packed


def drag(frequency):
    return {"kind": "drag", "handle": NOTCH, "gesture": "g", "frequency": frequency}


async def answered(mailbox, sent, seconds=20.0):
    """Run a mailbox until it has said that it is done."""
    running = asyncio.create_task(mailbox.run())
    async with asyncio.timeout(seconds):
        while not any(part["part"] == "done" for part in sent):
            await asyncio.sleep(0.005)
    running.cancel()


def test_of_fifty_changes_that_wait_the_last_is_shown_once(tmp_path):
    session, sent = session_of(written(tmp_path)), []

    async def send(part):
        sent.append(part)

    async def go():
        mailbox = Mailbox(session, send)
        for step in range(50):
            mailbox.put({"id": step, **drag(1.0 + 0.01 * step)})
        await answered(mailbox, sent)

    asyncio.run(go())
    assert [part["part"] for part in sent].count("numbers") == 1
    assert {part["id"] for part in sent} == {49}
    assert session.state.content["controller"]["filters"][0]["frequency"] == "107.28 Hz"


def test_what_takes_longer_is_left_out_for_something_newer(tmp_path):
    session, sent = session_of(written(tmp_path)), []

    async def go():
        async def send(part):
            sent.append(part)
            if part["part"] == "ready" and part["id"] == 1:
                mailbox.put({"id": 2, **drag(1.2)})

        mailbox = Mailbox(session, send)
        mailbox.put({"id": 1, **drag(1.1)})
        await answered(mailbox, sent)

    asyncio.run(go())
    first = [part["part"] for part in sent if part["id"] == 1]
    assert first == ["numbers", "status", "curves", "closed", "ready"]
    assert "response" in [part["part"] for part in sent if part["id"] == 2]


def test_arrays_go_as_bytes_beside_plain_data():

    part = {
        "part": "x",
        "list": [1.5, float("inf")],
        "array": np.linspace(0, 1, 5),
        "n": np.int64(3),
    }
    plain, buffers = packed(part)
    assert plain == {"part": "x", "list": [1.5, None], "array": {"$array": 0}, "n": 3}
    assert np.frombuffer(buffers[0], "<f4") == pytest.approx(part["array"])
    frame = framed(part)
    length = int.from_bytes(frame[:4], "little")
    head, sizes = json.loads(frame[4 : 4 + length])
    assert head == plain
    assert sizes == [20]
    assert frame[4 + length :] == buffers[0]
