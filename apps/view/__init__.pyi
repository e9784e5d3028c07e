from .moving import View as View
from .moving import view_of as view_of
from .moving import view_of_answer as view_of_answer
from .viser_page import html_of as html_of
from .viser_page import open_view as open_view
from .viser_page import require_viewer as require_viewer
