"""Draw docs/images/report.png and report_dark.png: what `belt report` makes of the demonstration.

Needs selenium, Chromium and its driver: apt-get install chromium chromium-driver.
Run it as `.venv/bin/python tools/make_report_picture.py`.
"""

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from selenium import webdriver

from belt_ros.replay import replay
from belt_ros.report import write_report
from belt_ros.rig import load_scenario, simulate
from belt_ros.rig.bag import write_bag
from belt_ros.settings import load_settings

REPOSITORY = Path(__file__).resolve().parents[1]
IMAGES = REPOSITORY / "docs" / "images"
CONFIG = REPOSITORY / "config" / "demo_drive.yaml"
SCENARIO = REPOSITORY / "config" / "scenarios" / "demo.yaml"
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
DRIVER = shutil.which("chromedriver")
_FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)


@contextmanager
def chromium(profile: Path, *flags: str, logs: tuple[str, ...] = ()) -> Iterator[webdriver.Chrome]:
    """Start a browser without a window, and end it.

    Parameters
    ----------
    profile : Path
        Where it keeps what it needs.
    *flags : str
        Of its command line.
    logs : tuple of str
        Which of its logs are kept, such as ``browser``.
    """
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM or ""
    for flag in (*_FLAGS, *flags, f"--user-data-dir={profile}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", dict.fromkeys(logs, "ALL"))
    driver = webdriver.Chrome(options, webdriver.ChromeService(DRIVER))
    try:
        yield driver
    finally:
        driver.quit()


def make_report(place: Path) -> Path:
    """Simulate, replay and report."""
    settings = load_settings(CONFIG)
    samples = simulate(settings, load_scenario(SCENARIO, settings))
    write_bag(place / "demo", settings.name, samples)
    replay(place / "demo", settings, place / "results")
    write_report(place / "results", place / "report.html")
    return place / "report.html"


def take_pictures(page: Path, profile: Path) -> None:
    """Photograph the head of the page, and in the dark where load meets slip."""
    with chromium(profile, "--hide-scrollbars", "--window-size=1000,1180") as driver:
        driver.get(page.as_uri())
        driver.save_screenshot(str(IMAGES / "report.png"))
        dark = {"name": "prefers-color-scheme", "value": "dark"}
        driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [dark]})
        driver.set_window_size(1000, 800)
        driver.refresh()
        driver.execute_script("document.getElementById('load').scrollIntoView()")
        driver.save_screenshot(str(IMAGES / "report_dark.png"))


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as place:
        take_pictures(make_report(Path(place)), Path(place) / "profile")
