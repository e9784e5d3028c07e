"""A matplotlib figure as inline SVG: no address in it, no identifier twice in a page."""

from __future__ import annotations

import io
import re

from ..figures import Drawing
from .markup import Html, tag

_HEAD = re.compile(r"^.*?(?=<svg\b)", re.DOTALL)
_METADATA = re.compile(r"<metadata>.*?</metadata>\s*", re.DOTALL)
_FONTS = re.compile(r"(font: [^;\"]*?)'DejaVu Sans'[^;\"]*")


def figure_html(drawing: Drawing) -> Html:
    """The figure with its caption; a wide one scrolls where the screen is narrow."""
    wide = " wide" if drawing.figure.get_figwidth() > 7.5 else ""
    return tag(
        "figure",
        tag("div", inline_svg(drawing), class_="drawing" + wide, tabindex="0", role="group",
            aria_label=f"figure {drawing.name}"),
        tag("figcaption", drawing.caption),
        id=f"figure-{drawing.name}",
    )  # fmt: skip


def inline_svg(drawing: Drawing) -> Html:
    """The drawing alone, with a description for those who do not see it.

    Text stays text, set in the reader's own fonts; the same figure gives the same text.
    """
    import matplotlib

    stream = io.StringIO()
    with matplotlib.rc_context({"svg.hashsalt": drawing.name, "svg.fonttype": "none", "axes.unicode_minus": True}):
        nothing = dict.fromkeys(("Date", "Creator", "Format", "Type"))
        drawing.figure.savefig(stream, format="svg", metadata=nothing)
    text = _METADATA.sub("", _HEAD.sub("", stream.getvalue()))
    text = without_namespaces(text)
    text = _FONTS.sub(r"\1sans-serif", text)
    text = _own_names(text, f"{drawing.name}-")
    text = re.sub(r' (?:width|height)="[\d.]+pt"', "", text, count=2)
    label = f"{drawing.name}-text"
    described = f'<svg role="img" aria-labelledby="{label}" '
    text = text.replace("<svg ", described, 1)
    at = text.index(">") + 1
    return Html(text[:at] + tag("title", drawing.text, id=label) + text[at:])


def without_namespaces(svg: str) -> Html:
    """An SVG document's element as HTML wants it inline: without the addresses that name its kind."""
    return Html(re.sub(r' xmlns(?::xlink)?="[^"]*"', "", _HEAD.sub("", svg)).replace("xlink:href", "href"))


def _own_names(text: str, prefix: str) -> str:
    """Identifiers that only one figure has; those that nothing refers to go."""
    used = set(re.findall(r'(?:href="#|url\(#)([^")]+)', text))
    text = re.sub(r' id="([^"]+)"', lambda m: f' id="{prefix}{m[1]}"' if m[1] in used else "", text)
    return re.sub(r'(href="#|url\(#)', rf"\g<1>{prefix}", text)
