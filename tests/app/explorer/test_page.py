"""The page itself: a notch is dragged, the margins are read, what was done is undone."""

from explored import NOTCH
from explorer_pages import at_rest, drag, field, margins, needs_browser, shown

needs_browser(whole=True)


def test_a_dragged_notch_shows_the_margins_that_python_has(page, path):
    assert shown(page) == margins(path).phase_margin_deg
    drag(page, 40, -20)
    values = {
        f"{NOTCH}.{name}": field(page, f"{NOTCH}.{name}") for name in ("frequency", "zero_damping")
    }
    assert values[f"{NOTCH}.frequency"] != "72 Hz"
    exact = margins(path, **values)
    assert shown(page) == exact.phase_margin_deg
    assert shown(page, "sensitivity_peak") == exact.sensitivity_peak
    page.click("text=Undo")
    at_rest(page)
    assert shown(page) == margins(path).phase_margin_deg
    assert field(page, f"{NOTCH}.frequency") == "72 Hz"
    page.keyboard.press("Control+y")
    at_rest(page)
    assert shown(page) == exact.phase_margin_deg
