"""HTML that cannot be broken by what it holds: every text is escaped on its way in."""

import base64
import hashlib
from collections.abc import Iterable, Sequence
from html import escape
from importlib.resources import files
from typing import NamedTuple

_CONTROLS = {code: "�" for code in range(32) if chr(code) not in "\t\n"} | {127: "�"}


class Html(str):
    """Text that is markup already."""

    __slots__ = ()


def text(value: object) -> Html:
    """Return `value` as markup: as it is if it is `Html`, else escaped."""
    if isinstance(value, Html):
        return value
    plain = str(value).translate(_CONTROLS).encode("utf-8", "replace").decode("utf-8")
    return Html(escape(plain, quote=True))


def tag(name: str, *contents: object, **attributes: str) -> Html:
    """Return an element; an underscore at the end of an attribute's name is dropped."""
    given = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{text(value)}"' for key, value in attributes.items()
    )
    return Html(f"<{name}{given}>{join(contents)}</{name}>")


def join(parts: Iterable[object]) -> Html:
    """Return parts one after another."""
    return Html("".join(text(part) for part in parts))


def table(caption: str, headings: Sequence[object], rows: Iterable[Sequence[object]]) -> Html:
    """Return a table, the first column of which names the rows."""
    head = tag("tr", *(tag("th", heading, scope="col") for heading in headings))
    body = join(
        tag("tr", tag("th", first, scope="row"), *(tag("td", cell) for cell in others))
        for first, *others in rows
    )
    inner = tag("table", tag("caption", caption), tag("thead", head), tag("tbody", body))
    return tag("div", inner, class_="table", tabindex="0", role="region", aria_label=caption)


def section(name: str, title: str, *contents: object) -> Html:
    """Return a part of the page with its heading; `name` is its identity."""
    heading = tag("h2", title, id=f"{name}-title")
    return tag("section", heading, *contents, id=name, aria_labelledby=f"{name}-title")


class Asset(NamedTuple):
    """A script or style sheet of this package."""

    content: str

    @property
    def source(self) -> str:
        """What a content security policy calls it."""
        digest = hashlib.sha256(self.content.encode()).digest()
        return f"'sha256-{base64.b64encode(digest).decode('ascii')}'"


def asset(name: str) -> Asset:
    """Return a file of belt_ros/report/assets."""
    return Asset((files("belt_ros.report") / "assets" / name).read_text(encoding="utf-8"))


def joined(names: Sequence[str]) -> Asset:
    """Return scripts as one, in which each knows the names of all, and nothing else does."""
    parts = "\n".join(asset(name).content for name in names)
    return Asset(f'"use strict";\n(() => {{\n{parts}}})();\n')


def document(
    title: str, body: Html, data: str, styles: Sequence[str], scripts: Sequence[str]
) -> str:
    """Return a page that loads nothing, and runs no script but `scripts`.

    Parameters
    ----------
    title : str
    body : Html
    data : str
        JSON without the character "<", for the element with the identity ``data``.
    styles, scripts : sequence of str
        Names of assets. The scripts become one.
    """
    sheets = [asset(name) for name in styles]
    codes = [joined(scripts)] if scripts else []
    policy = "; ".join(
        (
            "default-src 'none'",
            f"style-src {' '.join(sheet.source for sheet in sheets)}",
            f"script-src {' '.join(code.source for code in codes)}",
            "img-src data:",
            "base-uri 'none'",
            "form-action 'none'",
        )
    )
    head = [
        '<meta charset="utf-8">',
        f'<meta http-equiv="Content-Security-Policy" content="{text(policy)}">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        '<meta name="color-scheme" content="light dark">',
        '<link rel="icon" href="data:,">',
        tag("title", title),
        *(f"<style>{sheet.content}</style>" for sheet in sheets),
    ]
    tail = [
        f'<script type="application/json" id="data">{data}</script>',
        *(f"<script>{code.content}</script>" for code in codes),
    ]
    page = ["<!DOCTYPE html>", '<html lang="en">', "<head>", *head, "</head>"]
    page += ["<body>", body, *tail, "</body>", "</html>", ""]
    return "\n".join(page)
