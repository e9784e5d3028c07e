"""Options that several commands share: declared once, read once, handed on as frozen values."""

from ..entry import Options as Options
from .knowledge import GainOptions as GainOptions
from .knowledge import KnowledgeOptions as KnowledgeOptions
from .outputs import EquationOptions as EquationOptions
from .outputs import PageOptions as PageOptions
from .outputs import ResultOptions as ResultOptions
from .outputs import ViewedPageOptions as ViewedPageOptions
from .outputs import ViewOptions as ViewOptions
from .outputs import print_lines as print_lines
from .recordings import FilterOptions as FilterOptions
from .recordings import LogOptions as LogOptions
from .recordings import PairOptions as PairOptions
from .recordings import ProcessingOptions as ProcessingOptions
from .recordings import Setup as Setup
from .robots import ArmOptions as ArmOptions
from .robots import FramedRobotOptions as FramedRobotOptions
from .robots import HostOptions as HostOptions
from .robots import RehearsedRobotOptions as RehearsedRobotOptions
from .robots import RobotOptions as RobotOptions
