from .moving import View as View
from .moving import html_of as html_of
from .moving import open_view as open_view
from .moving import require_viewer as require_viewer
from .moving import view_of as view_of
from .moving import view_of_answer as view_of_answer
