"""The page in a real Chromium, from the file system."""

import json
import re
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from long_results import repeated

from belt_ros.report import write_report

webdriver = pytest.importorskip("selenium.webdriver", reason="selenium is not installed")

pytestmark = pytest.mark.slow
NUMBER = r"[−\d.]+"


@pytest.fixture(scope="module")
def browser(tools, tmp_path_factory):
    from make_report_picture import CHROMIUM, DRIVER, chromium  # noqa: PLC0415

    if CHROMIUM is None or DRIVER is None:
        pytest.skip("needs Chromium and chromedriver")
    profile, logs = tmp_path_factory.mktemp("profile"), ("browser", "performance")
    with chromium(profile, "--window-size=1100,1000", logs=logs) as driver:
        yield driver


@pytest.fixture(scope="module")
def report(results, tmp_path_factory):
    out = tmp_path_factory.mktemp("browser") / "report.html"
    write_report(results, out, results)
    return out


@pytest.fixture
def page(browser, report):
    browser.get_log("performance")
    browser.get_log("browser")
    browser.get(report.as_uri())
    assert browser.execute_script("return document.documentElement.dataset.ready") == "yes"
    return browser


@pytest.fixture(scope="module")
def table(results):
    return pq.read_table(results / "estimates.parquet").to_pydict()


def complaints(browser):
    return [entry["message"] for entry in browser.get_log("browser")]


def requests(browser):
    """Addresses that the page asked for."""
    messages = (json.loads(entry["message"])["message"] for entry in browser.get_log("performance"))
    return [
        message["params"]["request"]["url"]
        for message in messages
        if message["method"] == "Network.requestWillBeSent"
    ]


def point(browser, chart, share):
    """Move the mouse over a chart, to a share of its width."""
    over = browser.find_element("css selector", f"#chart-{chart} .u-over")
    browser.execute_script("arguments[0].scrollIntoView({block: 'center'})", over)
    width = over.size["width"]
    away = round((share - 0.5) * width)
    webdriver.ActionChains(browser).move_to_element_with_offset(over, away, 0).perform()


def legend(browser, chart):
    """What stands below a chart, by name."""
    rows = browser.find_elements("css selector", f"#chart-{chart} .u-series:not(.helper)")
    return {
        row.find_element("css selector", ".u-label").text: row.find_element(
            "css selector", ".u-value"
        ).text
        for row in rows
    }


def row_at(table, time):
    """The row at a time [s] after the first."""
    stamps = np.array(table["stamp_ns"])
    return int(np.argmin(np.abs((stamps - stamps[0]) * 1e-9 - time)))


def ticks(browser):
    """Time that the first chart shows, from its legend at both ends."""
    shown = []
    for share in (0.002, 0.998):
        point(browser, "margin", share)
        shown.append(float(legend(browser, "margin")["time"].removesuffix(" s")))
    return shown


def numbers(text):
    return [float(found.replace("−", "-")) for found in re.findall(NUMBER, text)]


def drawn(browser, chart):
    """How many colours a chart's picture has."""
    return browser.execute_script(
        "const c = document.querySelector(`#chart-${arguments[0]} canvas`);"
        "const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;"
        "return new Set(new Uint32Array(d.buffer)).size;",
        chart,
    )


def test_it_renders_without_complaint_and_asks_for_nothing_but_itself(page, report):
    for chart in ("slip", "tension", "stiffness", "margin", "torque", "alarms", "load"):
        assert drawn(page, chart) > 10, chart
    assert complaints(page) == []
    assert {url for url in requests(page) if not url.startswith("data:")} == {report.as_uri()}


@pytest.mark.parametrize(
    ("chart", "label", "column", "factor"),
    [
        ("margin", "margin", "margin", 100.0),
        ("tension", "tight", "tight_tension", 1.0),
        ("slip", "slip", "slip", 100.0),
        ("torque", "capacity", "capacity_torque", 1.0),
    ],
)
def test_numbers_at_the_mouse_are_those_of_the_table(page, table, chart, label, column, factor):
    for share in (0.35, 0.6, 0.8):
        point(page, chart, share)
        shown = legend(page, chart)
        (time,) = numbers(shown["time"])
        row = row_at(table, time)
        value, error = numbers(shown[label])
        stddev = factor * table[f"{column}_stddev"][row]
        assert value == pytest.approx(factor * table[column][row], abs=0.06 * stddev + 1e-9)
        assert error == pytest.approx(stddev, rel=0.06)


def test_friction_stiffness_is_shown_with_its_log_normal_interval(page, table):
    point(page, "stiffness", 0.6)
    shown = legend(page, "stiffness")
    (time,) = numbers(shown["time"])
    row = row_at(table, time)
    value, _, low, high = numbers(shown["kf"])
    median = 1e-6 * table["friction_stiffness"][row]
    factor = np.exp(1.96 * table["friction_stiffness_log_stddev"][row])
    assert value == pytest.approx(median, rel=0.02)
    assert (low, high) == (
        pytest.approx(median / factor, rel=0.02),
        pytest.approx(median * factor, rel=0.02),
    )


def test_charts_read_together(page):
    point(page, "margin", 0.5)
    assert legend(page, "margin")["time"] == legend(page, "tension")["time"]


def test_dragging_zooms_all_charts_and_a_button_takes_it_back(page):
    whole = ticks(page)
    over = page.find_element("css selector", "#chart-slip .u-over")
    page.execute_script("arguments[0].scrollIntoView({block: 'center'})", over)
    quarter = round(over.size["width"] / 4)
    chain = webdriver.ActionChains(page).move_to_element_with_offset(over, 0, 0).click_and_hold()
    chain.move_by_offset(quarter, 0).release().perform()
    start, end = ticks(page)
    length = whole[1] - whole[0]
    assert start == pytest.approx(whole[0] + 0.5 * length, abs=0.02 * length)
    assert end == pytest.approx(whole[0] + 0.75 * length, abs=0.02 * length)
    page.find_element("id", "whole").click()
    assert ticks(page) == whole
    assert complaints(page) == []


def test_keys_zoom(page):
    whole = ticks(page)
    page.execute_script("document.getElementById('chart-slip').focus()")
    page.switch_to.active_element.send_keys("++")
    start, end = ticks(page)
    assert end - start == pytest.approx((whole[1] - whole[0]) / 1.5**2, rel=0.05)


def test_hindsight_can_be_looked_at(page, results):
    page.find_element("css selector", "[data-mode=smoothed]").click()
    smoothed = pq.read_table(results / "smoothed.parquet").to_pydict()
    point(page, "margin", 0.6)
    shown = legend(page, "margin")
    (time,) = numbers(shown["time"])
    row = row_at(smoothed, time)
    assert numbers(shown["margin"])[0] == pytest.approx(
        100.0 * smoothed["margin"][row], abs=10.0 * smoothed["margin_stddev"][row] + 1e-9
    )
    page.find_element("css selector", "[data-mode=both]").click()
    assert "margin, hindsight" in legend(page, "margin")
    assert complaints(page) == []


def test_an_alarm_can_be_read(page, results):
    lanes = page.execute_script(
        "return JSON.parse(document.getElementById('data').textContent).alarms"
    )
    worst = max(lanes["intervals"], key=lambda item: (item["severity"], item["end"]))
    over = page.find_element("css selector", "#chart-alarms .u-over")
    page.execute_script("arguments[0].scrollIntoView({block: 'center'})", over)
    end = json.loads((results / "summary.json").read_text())["duration"]
    middle = 0.5 * (worst["start"] + worst["end"]) / end
    height = (worst["lane"] + 0.5) / len(lanes["lanes"])
    size = over.size
    webdriver.ActionChains(page).move_to_element_with_offset(
        over, round((middle - 0.5) * size["width"]), round((height - 0.5) * size["height"])
    ).perform()
    told = page.find_element("css selector", "#chart-alarms .told").text
    assert worst["message"] in told
    assert lanes["lanes"][worst["lane"]] in told


def test_a_cell_of_the_load_picture_can_be_read(page):
    cell = page.execute_script(
        "const l = JSON.parse(document.getElementById('data').textContent).load;"
        "const u = (p, T) => Array.from(new T(Uint8Array.from(atob(p.bytes),"
        " c => c.charCodeAt(0)).buffer));"
        "const n = u(l.count, Uint32Array), i = n.indexOf(Math.max(...n));"
        "return [(u(l.column, Uint16Array)[i] + 0.5) / l.columns,"
        " (u(l.row, Uint16Array)[i] + 0.5) / l.rows, n[i]];"
    )
    over = page.find_element("css selector", "#chart-load .u-over")
    page.execute_script("arguments[0].scrollIntoView({block: 'center'})", over)
    size = over.size
    webdriver.ActionChains(page).move_to_element_with_offset(
        over, round((cell[0] - 0.5) * size["width"]), round((0.5 - cell[1]) * size["height"])
    ).perform()
    told = page.find_element("css selector", "#chart-load .told").text
    assert "measurements, on average at" in told
    assert "N m, slip" in told


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_follows_the_colour_scheme(page, scheme):
    feature = {"name": "prefers-color-scheme", "value": scheme}
    page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [feature]})
    paper = page.execute_script("return getComputedStyle(document.body).backgroundColor")
    brightness = sum(int(part) for part in re.findall(r"\d+", paper)[:3]) / 3.0
    page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})
    assert (brightness > 128) == (scheme == "light")


def test_it_fits_a_phone(page):
    metrics = {"width": 390, "height": 844, "deviceScaleFactor": 2, "mobile": True}
    page.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    page.refresh()
    wide = page.execute_script("return document.documentElement.scrollWidth")
    page.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    assert wide <= 390


def test_it_prints(page):
    printed = page.print_page()
    assert len(printed) > 10_000
    assert complaints(page) == []


def test_a_poisoned_result_runs_nothing(browser, changed, tmp_path):
    def poison(summary):
        for name in ("drive", "bag", "topic", "note"):
            summary[name] = "</script><script>document.title='owned'</script><img src=x onerror=1>"

    out = Path(tmp_path / "report.html")
    write_report(changed(poison), out)
    browser.get_log("browser")
    browser.get(out.as_uri())
    assert browser.title.startswith("</script><script>")
    assert browser.execute_script("return document.images.length") == 0
    assert complaints(browser) == []


def test_a_run_too_long_for_a_page_shows_its_extremes(browser, results, table, tmp_path):
    out = tmp_path / "report.html"
    write_report(repeated(results, tmp_path / "long", 24), out)
    browser.get_log("browser")
    browser.get(out.as_uri())
    point(browser, "margin", 0.5)
    shown = legend(browser, "margin")["margin"]
    least, greatest, low, high = (
        number for number in numbers(shown.replace("95 %", "")) if number is not None
    )
    assert low <= least <= greatest <= high
    (time,) = numbers(legend(browser, "margin")["time"])
    stamps = np.array(table["stamp_ns"])
    period = (stamps[-1] - stamps[0] + 10_000_000) * 1e-9
    row = row_at(table, time % period)
    near = 100.0 * np.array(table["margin"])[max(row - 8, 0) : row + 9]
    assert np.min(near) - 0.01 <= least <= greatest <= np.max(near) + 0.01
    assert complaints(browser) == []
