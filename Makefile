# make demo, make test: each sets up .venv by itself; only Python 3.11+ is needed.
PYTHON ?= python3
BIN := .venv/bin
# The many commands that tests start start faster where Python may keep what it compiled.
unexport PYTHONDONTWRITEBYTECODE
# Python compiles what it imports, not all that is installed: a third of an installation's time.
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet install --no-compile
# The root folder is the package itself, and may have a name that is no package's ("my-dynident"): tests start below.
PYTEST := OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest tests -c pyproject.toml --rootdir=tests -n auto --dist worksteal

.PHONY: demo test test-all test-lowest test-newest lint docs bench clean

demo: .venv/installed
	$(BIN)/dynident demo

test: .venv/installed-test
	$(PYTEST) -m "not long"

test-all: .venv/installed-test
	$(PYTEST) --durations=40

# The short tests with the lowest versions of what pyproject.toml names, and with the newest, each in a folder of its
# own; uv chooses the versions. Old versions warn of what is newer than they are.
test-lowest: OLDEST := --resolution lowest-direct
test-lowest: IGNORED := -W ignore::DeprecationWarning
test-lowest: TRIED ?= 3.11
test-newest: TRIED ?= 3.13
test-lowest test-newest: .venv/bin/python
	$(PIP) uv
	$(BIN)/uv venv --quiet --clear --python $(TRIED) .venv/$@
	$(BIN)/uv pip install --quiet --python .venv/$@ $(OLDEST) --editable '.[test]'
	$(subst $(BIN),.venv/$@/bin,$(PYTEST)) -m "not long" $(IGNORED)

lint: .venv/installed-dev
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy -p dynident
	$(BIN)/lint-imports --no-cache

docs: .venv/installed-docs
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict

# Within an hour on two cores; DYNIDENT_DATA names the folder of real recordings, without which their parts are left out.
bench: .venv/installed-test
	@for name in regressor streaming constant_torques fleet hoses payload_sets \
	  weigh static design promised coverage peers; do \
	  echo "== $$name"; OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks $$name || exit 1; done

clean:
	rm -rf .venv build dist site *.egg-info tests/.pytest_cache

.venv/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "dynident needs Python 3.11 or newer: make PYTHON=/path/to/python3.11"; exit 1; }
	$(PYTHON) -m venv .venv

.venv/installed: .venv/bin/python pyproject.toml
	$(PIP) --editable .
	@touch $@

.venv/installed-test: .venv/bin/python pyproject.toml
	$(PIP) --editable '.[test]'
	@touch $@ .venv/installed

.venv/installed-dev: .venv/bin/python pyproject.toml
	$(PIP) --editable '.[dev]'
	@touch $@ .venv/installed .venv/installed-test

.venv/installed-docs: .venv/bin/python pyproject.toml
	$(PIP) --editable '.[docs]'
	@touch $@ .venv/installed
