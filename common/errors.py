"""The one error a user can mend: it says what is wrong, where, and what to do."""


class InputError(ValueError):
    """An input that cannot be used. The message is one line: what, where, what to do."""
