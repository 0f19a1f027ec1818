import json
import re
import shutil
import subprocess
import sys
from collections import Counter
from html.parser import HTMLParser

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from long_results import repeated

from belt_ros.estimation.alarm_settings import Condition
from belt_ros.report import ReportError, write_report
from belt_ros.report.labels import condition_name
from belt_ros.report.markup import Html, document, tag
from belt_ros.report.rounding import SPACE, duration

EVIL = "</script><script>alert(1)</script><img src=x onerror='alert(2)'>\"&\x00\ud800"


class Texts(HTMLParser):
    """Collects elements and attributes of a page."""

    def __init__(self):
        super().__init__()
        self.tags, self.attributes, self.data = [], [], []

    def handle_starttag(self, name, attributes):
        self.tags.append(name)
        self.attributes += attributes

    def handle_data(self, data):
        self.data.append(data)


def parsed(page):
    parser = Texts()
    parser.feed(page)
    return parser


@pytest.fixture(scope="module")
def page(results, tmp_path_factory):
    out = tmp_path_factory.mktemp("page") / "report.html"
    write_report(results, out)
    return out.read_text()


def test_the_page_tells_what_happened(page, results):
    text = " ".join(parsed(page).data).replace(SPACE, " ")
    summary = json.loads((results / "summary.json").read_text())
    assert "The belt slipped on a pulley" in text
    assert f"at {summary['worst_margin']['time']:.2f} s" in text
    assert f"{summary['accepted']:,} of {summary['messages']:,} messages were used" in text
    for heading in ("Over time", "Load against slip", "Alarms", "Estimates", "Data quality"):
        assert heading in text


def test_the_count_of_alarms_is_that_of_the_sentences(page):
    text = " ".join(parsed(page).data).replace(SPACE, " ")
    times = re.findall(r": raised (once|twice|\d+ times), first at", text)
    told = {"once": 1, "twice": 2}
    total = sum(told.get(word) or int(word.split()[0]) for word in times)
    assert total > 1
    assert re.search(rf"alarms\s*{total}\s*worst: ", text)


def rows_of(page, caption):
    """The cells of a table of the page, row by row."""
    table = re.search(rf"<caption>{caption}</caption>.*?</table>", page, re.DOTALL)[0]
    rows = re.findall(r"<tr>(.*?)</tr>", table.replace(SPACE, " "), re.DOTALL)[1:]
    return [
        ["".join(parsed(cell).data) for cell in re.split(r"(?=<t[hd])", row)[1:]] for row in rows
    ]


def shown(condition):
    return condition_name(Condition[condition.upper()])


def test_counts_of_alarms_and_the_time_in_each_are_those_of_the_summary(page, results):
    summary = json.loads((results / "summary.json").read_text())
    rows = rows_of(page, "Alarms by condition")
    told = {name: (int(times), inall) for name, _, times, inall, _ in rows}
    counts = Counter(shown(event["condition"]) for event in summary["alarms"])
    spent = {shown(name): time for name, time in summary["time_in_alarm"].items()}
    assert {name: times for name, (times, _) in told.items()} == counts
    assert {name: float(text.removesuffix(" s")) for name, (_, text) in told.items()} == (
        pytest.approx(spent, abs=0.01)
    )
    times = ", ".join(f"{kind} {duration(s)}" for kind, s in summary["time_in_severity"].items())
    assert f"Time in each severity: {times}." in page


def test_each_sensor_has_its_fit_among_the_data_quality(page):
    rows = rows_of(page, "Fit by sensor")
    assert [row[0] for row in rows] == [
        "driver speed",
        "driven speed",
        "driver torque",
        "driven torque",
        "positions",
    ]
    verdicts = ("consistent", "overconfident", "underconfident")
    assert all(row[1].startswith(verdicts) for row in rows)
    assert page.index("Data quality</h2>") < page.index("Fit by sensor</caption>")


def test_older_results_that_tell_less_have_a_page_too(changed, tmp_path):
    def older(summary):
        for name in ("alarms", "time_in_alarm", "time_in_severity"):
            del summary[name]

    copy = changed(older)
    write_report(copy, tmp_path / "with_bag.html")
    page = (tmp_path / "with_bag.html").read_text()
    assert [row[0] for row in rows_of(page, "Alarms by condition")]
    assert "Time in each severity" not in page
    shutil.rmtree(copy / "estimates")
    write_report(copy, tmp_path / "without.html")
    page = (tmp_path / "without.html").read_text()
    assert "Alarms by condition" not in page
    assert "Fit by sensor" not in page


def test_the_page_names_nothing_that_it_would_have_to_load(page):
    found = parsed(page)
    loading = {"src", "href", "srcset", "action", "data"}
    assert [value for name, value in found.attributes if name in loading] == ["data:,"]
    assert not re.search(r"@import|url\(|fetch\(|XMLHttpRequest|WebSocket|sendBeacon", page)
    assert "default-src 'none'" in " ".join(value or "" for _, value in found.attributes)


def test_alarms_are_told_of_without_the_bag_too(changed, tmp_path):
    copy = changed(lambda summary: None)
    shutil.rmtree(copy / "estimates")
    write_report(copy, tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text()
    assert "gross slip" in [row[0] for row in rows_of(page, "Alarms by condition")]
    assert "There was none." not in page


def test_nothing_that_a_file_contains_becomes_markup(changed, tmp_path):
    def poison(summary):
        for name in ("drive", "bag", "topic", "note"):
            summary[name] = EVIL
        summary["versions"] = {EVIL: EVIL}
        summary["rejected"] = {EVIL: 3}
        summary["alarms"][0] |= {"condition": EVIL, "severity": EVIL}
        summary["time_in_severity"] = {EVIL: 1.0}

    out = tmp_path / "report.html"
    write_report(changed(poison), out)
    found = parsed(out.read_text(encoding="utf-8"))
    assert found.tags.count("script") == 2
    assert "img" not in found.tags
    assert not [name for name, _ in found.attributes if name.startswith("on")]
    assert "alert(1)" in " ".join(found.data)


def test_every_text_is_escaped_on_its_way_into_markup():
    assert tag("p", "<b>", title='"&') == '<p title="&quot;&amp;">&lt;b&gt;</p>'
    assert tag("p", tag("b", "x")) == "<p><b>x</b></p>"
    assert isinstance(tag("p", "x"), Html)


def test_only_scripts_of_the_package_may_run():
    page = document("t", Html(""), "{}", ["report.css"], ["numbers.js", "zoom.js"])
    policy = next(value for _, value in parsed(page).attributes if "script-src" in (value or ""))
    assert re.search(r"script-src 'sha256-[\w+/]{43}='; img-src", policy)
    assert "unsafe" not in policy


def test_the_baseline_is_compared(results, changed, tmp_path):
    def tighter(summary):
        summary["bag"] = "commissioning"
        best = summary["smoothed"]["best_known"]["mean_tension"]
        best["value"] += 20.0 * best["stddev"]

    out = tmp_path / "report.html"
    write_report(results, out, changed(tighter))
    text = " ".join(parsed(out.read_text()).data)
    assert "Against the baseline" in text
    assert "commissioning" in text
    assert "significantly lower (14.1 σ)" in text


def test_without_hindsight_there_is_a_report_too(changed, tmp_path):
    copy = changed(lambda summary: summary.update(smoothed=None))
    (copy / "smoothed.parquet").unlink()
    write_report(copy, tmp_path / "report.html")
    assert "with hindsight</button>" not in (tmp_path / "report.html").read_text()


def test_without_the_bag_of_estimates_there_is_a_report_too(changed, tmp_path):
    copy = changed(lambda summary: None)
    shutil.rmtree(copy / "estimates")
    write_report(copy, tmp_path / "report.html")
    assert "The belt slipped" in (tmp_path / "report.html").read_text()


def damage(name, content):
    def apply(copy):
        (copy / name).write_bytes(content)

    return apply


def without_rows(copy):
    table = pq.read_table(copy / "estimates.parquet")
    pq.write_table(table.slice(0, 0), copy / "estimates.parquet")


def without_column(copy):
    table = pq.read_table(copy / "estimates.parquet")
    pq.write_table(table.drop_columns(["margin_stddev"]), copy / "estimates.parquet")


def with_text(copy):
    table = pq.read_table(copy / "estimates.parquet")
    place = table.schema.get_field_index("margin")
    texts = pa.array(["x"] * table.num_rows)
    pq.write_table(table.set_column(place, "margin", texts), copy / "estimates.parquet")


def cut(copy):
    place = copy / "estimates.parquet"
    place.write_bytes(place.read_bytes()[:-4000])


@pytest.mark.parametrize(
    ("harm", "said"),
    [
        (damage("summary.json", b"{"), "no valid JSON"),
        (damage("summary.json", b"[1, 2]"), "no summary of a replay"),
        (damage("summary.json", b"\xff\xfe"), "no valid JSON"),
        (damage("summary.json", b'{"final": {}}'), "mean_tension is missing or damaged"),
        (damage("estimates.parquet", b"PAR1"), "no readable Parquet table"),
        (damage("smoothed.parquet", b"none"), "no readable Parquet table"),
        (cut, "no readable Parquet table"),
        (without_rows, "holds no rows"),
        (without_column, "no column margin_stddev"),
        (with_text, "damaged"),
    ],
)
def test_a_damaged_result_is_refused_in_one_line(harm, said, changed, tmp_path):
    copy = changed(lambda summary: None)
    harm(copy)
    out = tmp_path / "report.html"
    with pytest.raises(ReportError, match=said) as caught:
        write_report(copy, out)
    assert str(copy) in str(caught.value)
    assert not out.exists()


@pytest.mark.parametrize("value", ["many", None, float("inf"), True, [1], {"x": 1}, 10**400])
def test_a_summary_with_a_wrong_value_is_refused(value, changed, tmp_path):
    copy = changed(lambda summary: summary.update(duration=value))
    with pytest.raises(ReportError, match="duration is missing or damaged"):
        write_report(copy, tmp_path / "report.html")


def test_what_is_no_result_directory_is_told_so(tmp_path):
    for place in (tmp_path, tmp_path / "absent"):
        with pytest.raises(ReportError, match="is no result directory"):
            write_report(place, tmp_path / "report.html")


def test_a_report_that_cannot_be_written_is_told_so(results, tmp_path):
    with pytest.raises(ReportError, match="is a directory"):
        write_report(results, tmp_path)
    (tmp_path / "file").write_text("")
    with pytest.raises(ReportError, match="cannot write"):
        write_report(results, tmp_path / "file" / "report.html")


PEAK = (
    "import resource, sys; from pathlib import Path; from belt_ros.report import write_report; "
    "write_report(Path(sys.argv[1]), Path(sys.argv[2])); "
    "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)"
)


@pytest.mark.slow
def test_memory_and_page_stay_small_however_long_the_run(results, tmp_path):
    peaks, sizes, rows = [], [], []
    for times in (144, 576):  # some 100,000 and 400,000 rows
        long = repeated(results, tmp_path / f"long{times}", times)
        out = tmp_path / f"{times}.html"
        command = [sys.executable, "-c", PEAK, str(long), str(out)]
        told = subprocess.run(command, check=True, capture_output=True, text=True)
        peaks.append(1024 * int(told.stdout))
        sizes.append(out.stat().st_size)
        rows.append(pq.read_metadata(long / "estimates.parquet").num_rows)
    # The columns that are read have some 290 bytes a row.
    assert (peaks[1] - peaks[0]) / (rows[1] - rows[0]) < 100
    assert max(sizes) < 3_000_000


def test_a_run_that_could_not_be_used_gets_no_all_clear(changed, tmp_path):
    def unstamped(summary):
        summary["accepted"] = 1

    write_report(changed(unstamped), tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text()
    assert "messages could be used: look at the data quality first." in page
    assert "there was no alarm" not in page


def test_a_stiffness_known_by_decades_is_shown_with_a_factor(changed, tmp_path):
    def wide(summary):
        summary["smoothed"] = None
        summary["final"]["friction_stiffness"] |= {"value": 2.5e8, "stddev": 7e9}

    write_report(changed(wide), tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text()
    assert "250 ×/÷ " in page
    assert "± 7000" not in page
