"""A figure as inline SVG: no address in it, no identifier twice in a page."""

import re

from ..blocks import Drawing
from ..figures.canvas import svg_text
from .markup import Html, tag

_HEAD = re.compile(r"^.*?(?=<svg\b)", re.DOTALL)
_METADATA = re.compile(r"<metadata>.*?</metadata>\s*", re.DOTALL)
_FONTS = re.compile(r"(font: [^;\"]*?)'DejaVu Sans'[^;\"]*")


def inline_svg(drawing: Drawing) -> Html:
    """The drawing alone, with a description for those who do not see it.

    Text stays text, set in the reader's own fonts; the same figure gives the same text.
    """
    text = _HEAD.sub("", svg_text(drawing.figure, drawing.name))
    text = re.sub(r' xmlns(?::xlink)?="[^"]*"', "", text).replace("xlink:href", "href")  # HTML needs no address
    text = _METADATA.sub("", text)
    text = _FONTS.sub(r"\1sans-serif", text)
    text = _own_names(text, f"{drawing.name}-")
    text = re.sub(r' (?:width|height)="[\d.]+pt"', "", text, count=2)
    label = f"{drawing.name}-text"
    described = f'<svg role="img" aria-labelledby="{label}" '
    text = text.replace("<svg ", described, 1)
    at = text.index(">") + 1
    return Html(text[:at] + tag("title", drawing.text, id=label) + text[at:])


def _own_names(text: str, prefix: str) -> str:
    """Identifiers that only one figure has; those that nothing refers to go."""
    used = set(re.findall(r'(?:href="#|url\(#)([^")]+)', text))
    text = re.sub(r' id="([^"]+)"', lambda m: f' id="{prefix}{m[1]}"' if m[1] in used else "", text)
    return re.sub(r'(href="#|url\(#)', rf"\g<1>{prefix}", text)
