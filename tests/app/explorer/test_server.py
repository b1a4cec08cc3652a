"""The server: loopback, token, foreign pages refused, several pages, gone with the last one."""

import asyncio
import json
from urllib.error import HTTPError
from urllib.request import Request, urlopen

import pytest
from explored import NOTCH, session_of, written

from jounce.app.explorer import server
from jounce.app.explorer.server import Server

websockets = pytest.importorskip("websockets")


def served(tmp_path, visit, **options):
    """Run a server, visit it with its address, and return what that gives."""
    path = written(tmp_path)

    async def go():
        own = Server(lambda: session_of(path), **options)
        started = asyncio.get_running_loop().create_future()
        running = asyncio.create_task(own.run(started=started.set_result))
        async with asyncio.timeout(30):
            found = await visit(await started)
            own.end()
            await running
        return found

    return asyncio.run(go())


def asked(address, **headers):
    """Return status, headers and body of a request."""
    try:
        with urlopen(Request(address, headers=headers), timeout=10) as response:
            return response.status, dict(response.headers), response.read()
    except HTTPError as error:
        return error.code, dict(error.headers), error.read()


def over_http(tmp_path, *requests):
    """Return the answers to requests, each a path behind the token, or beside, and headers."""

    async def visit(address):
        base = address.rsplit("/", 2)[0]
        return [
            await asyncio.to_thread(asked, (address if inside else base + "/") + path, **headers)
            for inside, path, headers in requests
        ]

    return served(tmp_path, visit)


def test_the_page_and_its_files_are_served_with_the_token(tmp_path):
    names = ["", "explorer.js", "socket.js", "style.css", "secret.toml", "../state.py"]
    answers = over_http(tmp_path, *[(True, name, {}) for name in names])
    assert [status for status, _, _ in answers] == [200, 200, 200, 200, 404, 404]
    for _, headers, _ in answers[:4]:
        assert "default-src 'self'" in headers["Content-Security-Policy"]
        assert headers["Cache-Control"] == "no-store"
    assert b"socket.js" in answers[0][2]


def test_a_wrong_token_is_refused(tmp_path):
    answers = over_http(
        tmp_path, (False, "", {}), (False, "x" * 32 + "/", {}), (False, "explorer.js", {})
    )
    assert [status for status, _, _ in answers] == [403] * 3


def test_foreign_pages_and_foreign_names_are_refused(tmp_path):
    foreign = {"Origin": "http://evil.example"}, {"Host": "evil.example"}, {"Origin": "null"}
    answers = over_http(tmp_path, *[(True, "", headers) for headers in foreign])
    assert [status for status, _, _ in answers] == [403] * 3


def test_a_socket_is_refused_to_foreign_pages_and_without_the_token(tmp_path):
    async def visit(address):
        socket = address.replace("http:", "ws:") + "socket"
        own = address.rsplit("/", 2)[0]
        wrong = own.replace("http:", "ws:") + "/wrong/socket"
        found = []
        for where, origin in ((socket, "http://evil.example"), (wrong, own), (socket, "null")):
            with pytest.raises(websockets.exceptions.InvalidStatus) as refused:
                await websockets.connect(where, origin=origin)
            found.append(refused.value.response.status_code)
        return found

    assert served(tmp_path, visit) == [403, 403, 403]


def test_it_listens_on_this_machine_alone(tmp_path):
    async def visit(address):
        return address

    assert served(tmp_path, visit).startswith("http://127.0.0.1:")


async def talk(socket, *messages, until="ready"):
    """Send messages; return parts by name up to one."""
    for number, message in enumerate(messages):
        await socket.send(
            message if isinstance(message, str) else json.dumps({"id": number, **message})
        )
    found = {}
    while until not in found:
        frame = await socket.recv()
        length = int.from_bytes(frame[:4], "little")
        part, _ = json.loads(frame[4 : 4 + length])
        found[part["part"]] = part
    return found


def test_pages_have_states_of_their_own(tmp_path):
    async def visit(address):
        where, own = address.replace("http:", "ws:") + "socket", address.rsplit("/", 2)[0]
        async with websockets.connect(where, origin=own) as a, websockets.connect(where) as b:
            drag = {"kind": "drag", "handle": NOTCH, "gesture": "g", "frequency": 1.5}
            first = await talk(a, {"kind": "start"}, drag)
            second = await talk(b, {"kind": "start"})
        return first["status"], second["status"]

    first, second = served(tmp_path, visit)
    assert first["changed"]
    assert not second["changed"]


def test_messages_without_meaning_are_told(tmp_path):
    async def visit(address):
        async with websockets.connect(address.replace("http:", "ws:") + "socket") as socket:
            return [(await talk(socket, text))["problem"]["text"] for text in ("{", "[1]", '"x"')]

    assert all("unreadable" in text for text in served(tmp_path, visit))


def test_a_file_that_was_spoilt_meanwhile_is_told_to_the_page(tmp_path):
    async def visit(address):
        written(tmp_path, "plant = 3")
        async with websockets.connect(address.replace("http:", "ws:") + "socket") as socket:
            return (await talk(socket, until="problem"))["problem"]["text"]

    assert "plant" in served(tmp_path, visit)


def test_it_ends_with_its_last_page(tmp_path, monkeypatch):
    monkeypatch.setattr(server, "_GRACE", 0.05)
    path = written(tmp_path)

    async def go():
        own = Server(lambda: session_of(path))
        started = asyncio.get_running_loop().create_future()
        running = asyncio.create_task(own.run(started=started.set_result))
        async with asyncio.timeout(20):
            where = (await started).replace("http:", "ws:") + "socket"
            async with websockets.connect(where), websockets.connect(where) as other:
                await other.close()
                await asyncio.sleep(0.2)
                assert not running.done()
            await running

    asyncio.run(go())
