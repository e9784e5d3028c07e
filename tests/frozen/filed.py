"""Lines of tests, in which ``key=value`` stands for a line of a settings file."""

import functools
import json
import os
import tempfile
from collections.abc import Sequence
from pathlib import Path

from dynident.apps.commands import COMMANDS
from dynident.apps.commands.entry import application, shown_name

PLACE = Path(tempfile.gettempdir()) / f"dynident-settings-{os.getpid()}.toml"


@functools.cache
def keys() -> frozenset[str]:
    """Settings of all commands."""
    found = set()
    for name, (where, _) in COMMANDS.items():
        app = application([], ())
        for word in name.split() if where else ():
            app = app[word]
        arguments = app.assemble_argument_collection() if where else ()
        found |= {shown_name(argument) for argument in arguments if not (argument.show or argument.children)}
    return frozenset(found)


def filed(words: Sequence[str]) -> list[str]:
    """Words as they are typed: settings, ``key=value`` or ``key`` and its value, go into a file."""
    typed, settings, left = list[str](), dict[str, str](), iter(words)
    for word in left:
        key, mark, value = word.partition("=")
        if key in keys():
            settings[key] = value if mark else next(left, "")  # the last one counts, as of options
        else:
            typed.append(word)
    if not settings:
        return typed
    text = "".join(f"{key} = {json.dumps(value)}\n" for key, value in settings.items())
    if "--config" in typed:
        k = typed.index("--config")
        text += Path(typed[k + 1]).read_text(encoding="utf-8")
        del typed[k : k + 2]
    PLACE.write_text(text, encoding="utf-8")
    return [*typed, "--config", str(PLACE)]
