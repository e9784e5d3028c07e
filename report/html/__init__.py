"""Results as one self-contained HTML file: one section a file, one page builder, one style sheet.

A section is a function from results to a ``Section``; a page is its head, its sections and its figures.
"""

from .identification import identification_page, robot_section
from .markup import Html, bullets, joined, paragraph, printed_table, table, tag
from .page import Page, Section, write_plots, write_report
from .payload import payload_page
from .plain import plain_page, plain_section
from .provenance import Provenance, SourceFile
from .svg import without_namespaces
from .weighing import weigh_page

__all__ = [
    "Html",
    "Page",
    "Provenance",
    "Section",
    "SourceFile",
    "bullets",
    "identification_page",
    "joined",
    "paragraph",
    "payload_page",
    "plain_page",
    "plain_section",
    "printed_table",
    "robot_section",
    "table",
    "tag",
    "weigh_page",
    "without_namespaces",
    "write_plots",
    "write_report",
]
