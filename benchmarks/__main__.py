"""Run a benchmark from a checkout, however dynident was installed: ``python benchmarks NAME``, then its options.

An installation that is not editable lacks the folders of benchmarks and tests; they are found beside this file.
"""

import runpy
import sys
from pathlib import Path

import dynident

HERE = Path(__file__).parent
dynident.__path__.append(str(HERE.parent))
names = sorted(path.stem for path in HERE.glob("[a-z]*.py") if "__main__" in path.read_text(encoding="utf-8"))
if sys.argv[1:2] and sys.argv[1] in names:
    del sys.argv[0]
    runpy.run_module(f"dynident.benchmarks.{sys.argv[0]}", run_name="__main__", alter_sys=True)
else:
    sys.exit(f"python benchmarks NAME, of {' '.join(names)}")
