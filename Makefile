# Every target makes .venv when it is missing, and brings it up to date when pyproject.toml has changed.
# PYTHON=... names the interpreter that .venv is made from, 3.11 or later; VENV=... puts it elsewhere.

VENV ?= .venv
BIN := $(VENV)/bin
# The first interpreter on the path that is new enough; only looked for when .venv is missing.
FIND_PYTHON = for python in python3 python3.13 python3.12 python3.11; do \
	"$$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo "$$python" && break; done
PYTHON ?= $(shell $(FIND_PYTHON))
INSTALL = $(BIN)/python -m pip install --quiet --disable-pip-version-check --editable

.DELETE_ON_ERROR:
.PHONY: help run test lint bench million clean

help:
	@echo "make run      all solutions of the bundled arm, each with its branch, limits, collisions and Pinocchio's error"
	@echo "make test     the tests and the notebooks; ARGS='-k name' narrows them down"
	@echo "make lint     ruff, mypy, and notebooks without outputs"
	@echo "make bench    the benchmarks against other solvers; ARGS='--help' tells more"
	@echo "make million  a million random poses an arm: what is lost, doubled or off; ARGS='--help' tells more"
	@echo "make clean    remove .venv and what tools left behind"

run: $(VENV)/.run-installed
	@$(BIN)/urdf-ik ik zyyzyz_6r $(ARGS)

test: $(VENV)/.dev-installed
	$(BIN)/python -m pytest $(ARGS)

lint: $(VENV)/.dev-installed
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/nbstripout --verify --keep-id notebooks/*.ipynb

bench: $(VENV)/.bench-installed
	@$(BIN)/python benchmarks/bench.py $(ARGS)
	@$(BIN)/python benchmarks/few_joints.py
	@$(BIN)/python benchmarks/seven_joints.py

million: $(VENV)/.bench-installed
	@$(BIN)/python benchmarks/million.py $(ARGS)

clean:
	rm -rf $(VENV) build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis

$(BIN)/python:
	@test -n "$(PYTHON)" || { echo "Python 3.11 or later is needed, and none was found; PYTHON=... names one" >&2; exit 2; }
	$(PYTHON) -m venv $(VENV)

$(VENV)/.run-installed: pyproject.toml | $(BIN)/python
	$(INSTALL) .
	@touch $@

$(VENV)/.dev-installed: pyproject.toml | $(BIN)/python
	$(INSTALL) '.[dev]'
	@touch $@ $(VENV)/.run-installed

$(VENV)/.bench-installed: pyproject.toml | $(BIN)/python
	$(INSTALL) '.[bench]'
	@touch $@ $(VENV)/.run-installed
