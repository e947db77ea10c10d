# Two commands on a fresh machine: make demo, make test. Each makes .venv, installs what it needs
# and builds with colcon. Where ROS 2 Jazzy is sourced its rclpy is used, elsewhere PyPI's wheels.
SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := help

PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
OUT ?= out/demo
# Workers of the tests; a file's tests stay together, for they share what takes long to make.
WORKERS ?= auto
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check

ifeq ($(ROS_DISTRO),jazzy)
  VENV_FLAGS := --system-site-packages
  CONSTRAINTS := constraints-jazzy.txt
  ROS_PACKAGES :=
else
  VENV_FLAGS :=
  CONSTRAINTS := constraints.txt
  ROS_PACKAGES := 'ros-jazzy-rclpy[fastrtps]' ros-jazzy-common-interfaces
endif

.PHONY: help
help: ## Show this list.
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 16

$(BIN)/python:
	@$(PYTHON) -c 'import sys; v = sys.version_info; sys.exit(0 if (3, 10) <= v < (3, 13) else f"Python {v[0]}.{v[1]} was found, 3.10 to 3.12 is needed: make PYTHON=python3.11")'
	$(PYTHON) -m venv $(VENV_FLAGS) $(VENV)
	touch $(VENV)/COLCON_IGNORE

$(VENV)/.runtime: requirements.txt $(CONSTRAINTS) | $(BIN)/python
	$(PIP) -c $(CONSTRAINTS) -r requirements.txt 'setuptools<80' colcon-common-extensions $(ROS_PACKAGES)
	touch $@

$(VENV)/.test: $(VENV)/.runtime
	$(PIP) -c $(CONSTRAINTS) distributed hypothesis import-linter jsonschema playwright pytest pytest-xdist ruff mypy types-PyYAML torch viser 'setuptools<80'
	touch $@

.PHONY: build
build: $(VENV)/.runtime ## Build the ROS package with colcon into install/.
	@source $(BIN)/activate; \
	colcon list --base-paths . --packages-select diffcal_ros | grep -q 'ros.ament_python' \
	  || { echo 'package.xml is not valid: colcon does not see an ament_python package' >&2; exit 1; }; \
	colcon build --base-paths . --packages-select diffcal_ros; \
	python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .

.PHONY: demo
demo: build ## Replay the sample bag through the three nodes and fit it.
	@source $(BIN)/activate; set +u; source install/setup.bash; set -u; \
	python demo/run_demo.py --bag bags/sample --scene bags/sample/scene.yaml --out $(OUT)

.PHONY: lint
lint: $(VENV)/.test ## Check style, types and who imports whom.
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache --no-logo

# Says how many tests of a JUnit file ran; fails where none did.
TESTS_RAN := import sys, xml.etree.ElementTree as t; \
  suites = list(t.parse(sys.argv[1]).iter("testsuite")); \
  tests, skipped = (sum(int(s.get(key)) for s in suites) for key in ("tests", "skipped")); \
  print(f"{tests - skipped} tests ran, {skipped} were skipped"); \
  sys.exit(0 if tests > skipped else "no test ran")

.PHONY: test
test: lint build ## Lint, build and run every test but the slow ones; fails when anything failed or nothing ran.
	@source $(BIN)/activate; rm -rf build/diffcal_ros/pytest.xml; export OMP_NUM_THREADS=$${OMP_NUM_THREADS:-1}; \
	colcon test --base-paths . --packages-select diffcal_ros --event-handlers console_direct+ \
	  --return-code-on-test-failure --pytest-args -n $(WORKERS) --maxprocesses 4 --dist loadfile || failed=1; \
	colcon test-result --test-result-base build/diffcal_ros --verbose; \
	python -c '$(TESTS_RAN)' build/diffcal_ros/pytest.xml; \
	exit $${failed:-0}

.PHONY: test-gpu
test-gpu: $(VENV)/.test ## Run the tests that need a GPU; says so, and fails, where there is none.
	@mkdir -p build; rm -f build/gpu.xml; export OMP_NUM_THREADS=$${OMP_NUM_THREADS:-1}; \
	$(BIN)/python -m pytest -m gpu --junitxml build/gpu.xml || failed=1; \
	if [ ! -f build/gpu.xml ]; then echo 'NOTHING WAS RUN: pytest did not start, see above' >&2; failed=1; \
	elif ! $(BIN)/python -c '$(TESTS_RAN)' build/gpu.xml; then echo 'NOTHING WAS RUN: this machine has no GPU' >&2; failed=1; fi; \
	exit $${failed:-0}

.PHONY: test-slow
test-slow: $(VENV)/.test ## Run the slow tests, whole studies; fails when anything failed or nothing ran.
	@source $(BIN)/activate; mkdir -p build; rm -f build/slow.xml; export OMP_NUM_THREADS=$${OMP_NUM_THREADS:-1}; \
	python -m pytest -m slow -n $(WORKERS) --maxprocesses 4 --dist loadfile --durations 20 \
	  --junitxml build/slow.xml || failed=1; \
	python -c '$(TESTS_RAN)' build/slow.xml; \
	exit $${failed:-0}

BLIND ?= out/blind
.PHONY: blind
blind: $(VENV)/.test ## Diagnose the independent generator's cases and score them (slow).
	$(BIN)/python -m benchmarks.blind.generator --set development --out $(BLIND)
	$(BIN)/python -m benchmarks.diagnosis --cases $(BLIND)/cases --out $(BLIND)/run
	$(BIN)/python -m benchmarks.blind.scorer --verdicts $(BLIND)/run --labels $(BLIND)/labels --out $(BLIND)/score

.PHONY: blind-motion
blind-motion: $(VENV)/.test ## The same for released bodies and held loads (slow).
	$(BIN)/python -m benchmarks.blind.generator --motion --set development --out $(BLIND)/motion
	$(BIN)/python -m benchmarks.diagnosis --cases $(BLIND)/motion/cases --out $(BLIND)/motion/run
	$(BIN)/python -m benchmarks.blind.scorer --verdicts $(BLIND)/motion/run --labels $(BLIND)/motion/labels --out $(BLIND)/motion/score

.PHONY: other-worlds
other-worlds: $(VENV)/.test ## Diagnose some of those cases in other worlds, each against itself (hours).
	$(BIN)/python -m benchmarks.blind.generator --set development --out $(BLIND)
	$(BIN)/python -m benchmarks.other_worlds --cases $(BLIND)/cases --only 'clean_00[0-4]' 'case_0?0' --out $(BLIND)/other_worlds

.PHONY: twist
twist: $(VENV)/.test ## Twist a cantilever by half a turn over a grid of materials (needs DIFFCAL_DATA).
	$(BIN)/python benchmarks/twist.py

.PHONY: motion-fit
motion-fit: $(VENV)/.test ## Fit a released beam from ten random starts (a quarter of an hour).
	PYTHONPATH=. $(BIN)/python benchmarks/motion_fit.py

.PHONY: coarsening coarsening-shapes
coarsening: $(VENV)/.test ## Fit coarser meshes of a beam to a fine one, with each element.
	$(BIN)/python benchmarks/coarsening.py

coarsening-shapes: $(VENV)/.test ## The same on the data set's spine and dragon (DIFFCAL_DATA).
	$(BIN)/python benchmarks/coarsening_shapes.py spine
	$(BIN)/python benchmarks/coarsening_shapes.py dragon

ZOO ?= out/zoo
.PHONY: zoo
zoo: $(VENV)/.test ## Fit a zoo of bodies in cluttered views from far starts (an hour or more).
	OMP_NUM_THREADS=$${OMP_NUM_THREADS:-1} $(BIN)/python -m benchmarks.zoo --out $(ZOO) --pictures

COVERAGE ?= out/coverage
.PHONY: coverage
coverage: $(VENV)/.test ## Count how often the 95 % interval holds the truth in 1,000 clean fits (hours).
	OMP_NUM_THREADS=$${OMP_NUM_THREADS:-1} $(BIN)/python -m benchmarks.coverage --count 1000 --jobs 2 --out $(COVERAGE)

.PHONY: peers
PEERS ?= out/peers
peers: $(VENV)/.test ## Time torch-fem, jax-fem, Newton, Mitsuba and MuJoCo on our body (needs DIFFCAL_DATA, installs each).
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.peers --out $(PEERS)

.PHONY: test-faults faults
faults: test-faults
test-faults: $(VENV)/.test ## Try 3,000 damaged bags, scenes, machines and signals (a quarter of an hour).
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.faults

.PHONY: faults-kill faults-live
faults-kill: $(VENV)/.test ## Kill commands and nodes at 100 random moments.
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.faults.kill

faults-live: $(VENV)/.test ## Ten minutes of an erring camera before three nodes.
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.faults.live

CABLES ?= out/cables
.PHONY: cables
cables: $(VENV)/.test ## Fit the cable of the data set's finger from ten starts a pull (slow).
	@if [ -z "$${DIFFCAL_DATA:-}" ]; then echo 'skipped: set DIFFCAL_DATA to a clone of the public DiffCal data set'; \
	else $(BIN)/python benchmarks/cables.py $(CABLES); fi

DOCS ?= out/docs
.PHONY: docs
docs: | $(BIN)/python ## Build the pages of docs/ as a site; a warning fails.
	$(PIP) -r docs/requirements.txt
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --site-dir $(abspath $(DOCS))

.PHONY: clean
clean: ## Remove what was built; .venv stays.
	rm -rf build install log out
