"""Figures of results, one kind a file; each function returns a matplotlib figure with its words.

The same figures stand in the HTML report and, by ``--plots``, in files. matplotlib is imported when one is drawn.
"""

from .by_joints import joints_figure
from .canvas import Drawing, save_drawings
from .essential import essential_drawing
from .excitation import excitation_figure
from .flange import flange_figure
from .methods import methods_figure
from .repeats import repeats_figure
from .torques import prediction_figure, worst_joint_figure

__all__ = [
    "Drawing",
    "essential_drawing",
    "excitation_figure",
    "flange_figure",
    "joints_figure",
    "methods_figure",
    "prediction_figure",
    "repeats_figure",
    "save_drawings",
    "worst_joint_figure",
]
