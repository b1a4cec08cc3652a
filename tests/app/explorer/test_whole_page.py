"""The whole page: keys, saving, wrong files, a lost connection, links, pictures, a phone."""

import re

import numpy as np
import pytest
from explored import EXAMPLES, NOTCH, SCENARIO, session_of, written
from explorer_pages import HANDLE, Served, at_rest, drag, field, margins, needs_browser, shown
from PIL import Image

from jounce.app import load_scenario
from jounce.app.scenario_loop import servo_loop_of

needs_browser(whole=True)


def test_the_keyboard_alone_is_enough(page, path):
    page.focus(HANDLE)
    for key in ("ArrowRight", "ArrowRight", "ArrowDown", "+"):
        page.keyboard.press(key)
    at_rest(page)
    told = page.get_attribute(HANDLE, "aria-valuetext")
    assert told.startswith("74.91 Hz")
    assert field(page, f"{NOTCH}.frequency") == "74.909 Hz"
    assert page.evaluate("document.activeElement.dataset.handle") == NOTCH
    page.keyboard.press("Control+s")
    at_rest(page)
    assert load_scenario(path).controller.filters[0].frequency == pytest.approx(74.909)
    page.keyboard.press("Delete")
    at_rest(page)
    assert page.locator(HANDLE).count() == 0
    page.keyboard.press("Control+z")
    at_rest(page)
    assert page.locator(HANDLE).count() == 1


def test_everything_that_can_be_used_has_a_name(page):
    without = page.evaluate(
        """[...document.querySelectorAll('button, input, select, [role=slider], [role=img]')]
        .filter((each) => !(each.getAttribute('aria-label') || each.textContent.trim()
            || each.closest('label')?.textContent.trim()))
        .map((each) => each.outerHTML)"""
    )
    assert without == []
    assert page.get_attribute("html", "lang") == "en"


def test_saving_keeps_the_comments(page, path):
    drag(page, 30)
    frequency = field(page, f"{NOTCH}.frequency")
    page.click("button:text-is('Save')")
    at_rest(page)
    page.wait_for_selector("text=Saved two_modes.toml")
    assert path.read_text() == SCENARIO.replace('"72 Hz"', f'"{frequency}"')


def test_a_value_that_cannot_be_is_told_and_goes_back(page):
    page.fill('input[data-key="plant.inertia"]', "-2 kg m^2")
    page.keyboard.press("Tab")
    at_rest(page)
    assert "out of range" in page.inner_text("[role=alert]")
    assert field(page, "plant.inertia") == "2 kg m^2"
    page.fill('input[data-key="plant.inertia"]', "3")
    page.keyboard.press("Tab")
    at_rest(page)
    assert "no unit" in page.inner_text("[role=alert]")


def test_a_wrong_file_is_told_and_a_right_one_is_shown(page, path):
    page.set_input_files(
        "input[type=file]", {"name": "a.csv", "mimeType": "text/csv", "buffer": b"1;2"}
    )
    at_rest(page)
    assert "a.csv" in page.inner_text("[role=alert]")
    loop = servo_loop_of(load_scenario(path)).loop_transfer()
    lines = np.geomspace(0.5, 500.0, 60)
    values = np.array([loop(point) for point in np.exp(2j * np.pi * lines * 0.25e-3)])
    rows = [
        f"{f!r},{v.real!r},{v.imag!r}" for f, v in zip(lines.tolist(), values.tolist(), strict=True)
    ]
    content = "\n".join(["frequency [Hz],real,imag", *rows]).encode()
    page.select_option("[aria-label='what was measured']", "loop")
    page.set_input_files(
        "input[type=file]", {"name": "b.csv", "mimeType": "text/csv", "buffer": content}
    )
    at_rest(page)
    assert page.input_value("[aria-label='margins are of']") == "data"
    assert shown(page) == pytest.approx(margins(path).phase_margin_deg, abs=1.0)


def test_a_file_that_is_dropped_onto_the_page_is_opened(page, path):
    loop = servo_loop_of(load_scenario(path)).loop_transfer()
    lines = np.geomspace(0.5, 500.0, 60)
    values = np.array([loop(point) for point in np.exp(2j * np.pi * lines * 0.25e-3)])
    rows = np.column_stack([lines, values.real, values.imag]).tolist()
    content = "frequency [Hz],real,imag\n" + "\n".join(f"{f!r},{a!r},{b!r}" for f, a, b in rows)
    page.select_option("[aria-label='what was measured']", "loop")
    held = page.evaluate_handle(
        """content => {
            const held = new DataTransfer();
            held.items.add(new File([content], 'dropped.csv', { type: 'text/csv' }));
            return held;
        }""",
        content,
    )
    page.dispatch_event("#explorer", "dragover", {"dataTransfer": held})
    assert "dropping" in page.get_attribute("#explorer", "class")
    page.dispatch_event("#explorer", "drop", {"dataTransfer": held})
    at_rest(page)
    assert "dropping" not in page.get_attribute("#explorer", "class")
    assert page.input_value("[aria-label='margins are of']") == "data"
    assert "dropped.csv" in page.inner_text(".verdict")
    assert shown(page) == pytest.approx(margins(path).phase_margin_deg, abs=1.0)


def test_the_wheel_makes_a_notch_wider_and_narrower(page):
    widths = [field(page, f"{NOTCH}.{name}") for name in ("zero_damping", "pole_damping")]
    box = page.locator(f"{HANDLE} .dot").bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    place = page.evaluate("scrollY")
    for _ in range(2):
        page.mouse.wheel(0, -100)
    at_rest(page)
    assert field(page, f"{NOTCH}.pole_damping") == "55.125 %"
    assert field(page, f"{NOTCH}.zero_damping") == "5.5125 %"
    assert page.evaluate("scrollY") == place
    page.click("text=Undo")
    at_rest(page)
    assert [field(page, f"{NOTCH}.{name}") for name in ("zero_damping", "pole_damping")] == widths


def test_what_is_asked_is_added_changed_left_out_and_saved(page, path):
    page.select_option("[aria-label='to add to requirements']", "phase_margin")
    page.click("[aria-label='Add to requirements']")
    at_rest(page)
    page.fill("input[data-key='requirements.phase_margin.min']", "80 deg")
    page.keyboard.press("Tab")
    at_rest(page)
    assert "phase margin" in page.inner_text(".verdict")
    assert "≥ 80" in page.inner_text("tr[data-margin=phase_margin_deg]")
    page.click("[aria-label='leave out phase margin, min']")
    page.select_option("select[data-key=feedforward]", "by derivatives")
    at_rest(page)
    page.fill("input[data-key='feedforward.acceleration']", "1.9 N m s^2/rad")
    page.click("[data-view=move]")
    at_rest(page)
    assert page.is_visible("input[data-key='feedforward.acceleration']")
    page.keyboard.press("Control+s")
    page.wait_for_selector("text=Saved two_modes.toml")
    assert path.read_text() == SCENARIO + ('\n[feedforward]\nacceleration = "1.9 N m s^2/rad"\n')
    assert load_scenario(path).feedforward.acceleration == 1.9
    assert [each.name for each in load_scenario(path).requirements] == ["sensitivity_peak"]


def test_a_projector_shows_thick_lines_and_large_letters(page):
    looks = """() => [getComputedStyle(document.querySelector('.line.model')).strokeWidth,
        getComputedStyle(document.querySelector('#explorer')).fontSize].map(parseFloat)"""
    before = page.evaluate(looks)
    page.select_option("[aria-label=colours]", "projector")
    assert all(now > then for now, then in zip(page.evaluate(looks), before, strict=True))
    page.select_option("[aria-label=colours]", "auto")


def test_a_lost_connection_is_told_and_what_was_changed_comes_back(page, served):
    drag(page, 30)
    frequency, margin = field(page, f"{NOTCH}.frequency"), shown(page)
    served.stop()
    page.wait_for_selector("text=The connection is lost")
    served.again()
    page.wait_for_selector("text=The connection is lost", state="hidden")
    page.wait_for_function("document.querySelector('#explorer').dataset.idle === 'true'")
    at_rest(page)
    assert field(page, f"{NOTCH}.frequency") == frequency
    assert shown(page) == margin


def test_the_address_holds_the_state(page, browser):
    drag(page, 30)
    frequency = field(page, f"{NOTCH}.frequency")
    assert "#" in page.url
    other = browser.new_page()
    other.goto(page.url)
    at_rest(other)
    assert field(other, f"{NOTCH}.frequency") == frequency
    other.close()


@pytest.mark.parametrize("spoilt", ["%E0%A4%A", "%7Bbad"])
def test_an_address_that_was_cut_shows_the_file(browser, served, spoilt):
    page = browser.new_page()
    page.goto(f"{served.address}#{spoilt}")
    at_rest(page)
    assert "no state of this scenario" in page.inner_text("[role=alert]")
    assert field(page, f"{NOTCH}.frequency") == "72 Hz"
    page.close()


def test_a_file_that_is_too_large_is_told(page):
    page.evaluate(
        """() => document.getElementById('explorer').jounce.open(
            new File([new Uint8Array(41e6)], 'large.csv'))"""
    )
    assert "large.csv: 41 MB" in page.inner_text("[role=alert]")


def test_the_move_and_its_limits(page):
    page.click("[data-view=move]")
    at_rest(page)
    before = page.inner_text('tr[data-figure="duration"] td')
    page.fill('input[data-key="limits.axis.jerk"]', "100 rad/s^3")
    page.keyboard.press("Tab")
    at_rest(page)
    assert page.inner_text('tr[data-figure="duration"] td') != before
    caption = page.inner_text("figure:has(svg[aria-label^=jerk]) figcaption")
    assert re.search(r"at its limit \d+ % of the time", caption)


def test_a_session_that_is_about_a_move_opens_with_it(browser, path):
    def about_the_move():
        session = session_of(path)
        session.receive({"kind": "view", "view": "move"})
        return session

    own = Served(about_the_move)
    page = browser.new_page()
    page.goto(own.address)
    at_rest(page)
    assert page.is_visible('tr[data-figure="duration"]')
    assert page.get_attribute("[data-view=move]", "aria-selected") == "true"
    page.close()
    own.stop()


def test_pictures_are_whole(page, tmp_path):
    with page.expect_download() as told:
        page.click("button:text-is('SVG')")
    told.value.save_as(tmp_path / "a.svg")
    text = (tmp_path / "a.svg").read_text()
    assert text.count("<g transform") > 8
    assert "Open loop: gain" in text
    with page.expect_download() as told:
        page.click("button:text-is('PNG')")
    told.value.save_as(tmp_path / "a.png")
    with Image.open(tmp_path / "a.png") as picture:
        assert picture.width > 1500
        assert len(picture.convert("L").resize((60, 60)).getcolors()) > 5


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_phone_shows_all_without_scrolling_sideways(browser, served, scheme):
    page = browser.new_page()
    page.emulate_media(color_scheme=scheme)
    page.set_viewport_size({"width": 390, "height": 844})
    page.goto(served.address)
    at_rest(page)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    assert page.get_attribute("#explorer", "data-theme") == scheme
    page.close()


def test_nothing_queues(page):
    box = page.locator(f"{HANDLE} .dot").bounding_box()
    x, y = box["x"] + 6, box["y"] + 6
    page.mouse.move(x, y)
    page.mouse.down()
    for step in range(60):
        page.mouse.move(x + step, y)
    page.mouse.up()
    at_rest(page)
    sent = page.evaluate("document.getElementById('explorer').jounce.wire.count")
    assert sent < 60


@pytest.mark.parametrize(
    "name", ["telescope", "servo_drive", "gantry_crane", "lift", "rubin_mount"]
)
def test_every_example_is_shown(browser, tmp_path, name):
    path = written(tmp_path, (EXAMPLES / f"{name}.toml").read_text())
    own = Served(lambda: session_of(path))
    page = browser.new_page()
    page.goto(own.address)
    at_rest(page)
    assert shown(page) == margins(path).phase_margin_deg
    page.close()
    own.stop()
