"""HTML as text that escapes whatever is not markup already."""

import html


class Html(str):
    """Text that is markup; every other text is escaped where it enters."""

    __slots__ = ()


def escaped(text: str) -> Html:
    """Markup as it is, other text escaped, for content and for attributes."""
    return text if isinstance(text, Html) else Html(html.escape(text))


def joined(*parts: str) -> Html:
    """One after the other."""
    return Html("\n".join(escaped(part) for part in parts if part))


def tag(name: str, *content: str, **attributes: str) -> Html:
    """An element; ``class_`` and ``aria_label`` become class and aria-label."""
    written = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{html.escape(value)}"' for key, value in attributes.items()
    )
    return Html(f"<{name}{written}>{''.join(escaped(part) for part in content)}</{name}>")
