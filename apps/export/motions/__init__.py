"""A designed motion for a controller: one file a format, each with a head that says what the motion is."""

from ..format import formats

FORMATS = formats(__name__, __path__, head=lambda form, motion: (*motion.head, *form.remarks))
"""Every format by its name."""
