# make run and make test need a Debian or Ubuntu machine (x86_64), Python 3.10 to 3.13 with venv, and make; the rest comes from PyPI.

PYTHON ?= python3
SCENE ?= scarf
DURATION ?=
BENCH ?=
SOAK ?=

VENV := .venv
BIN := $(VENV)/bin
PEERS := .venv-peers

# One pip at a time, even under make -j.
.NOTPARALLEL:
.DEFAULT_GOAL := help
.PHONY: help run test gallery bench bars soak peers validate lint format clean

# A sourced ROS would put its own Python packages, libraries and middleware beside the wheels of the environment.
unexport PYTHONPATH PYTHONHOME AMENT_PREFIX_PATH LD_LIBRARY_PATH RMW_IMPLEMENTATION _ROS_WHEELS_BOOTSTRAP_COMPLETE
export PIP_DISABLE_PIP_VERSION_CHECK = 1

# An environment of ours that was moved, or whose Python went away, is made again: its commands name the place of their birth.
ifneq ($(filter-out help clean,$(MAKECMDGOALS)),)
ifneq ($(wildcard $(VENV)/place),)
ifneq ($(shell $(BIN)/python -ISc '' 2>&1 && cat $(VENV)/place),$(CURDIR))
$(info The environment in $(VENV) was moved or lost its Python; making it again.)
$(shell rm -rf $(VENV))
endif
endif
endif

help: ## list the targets
	@echo "make run [SCENE=scarf] [DURATION=seconds], make test, ... (PYTHON=python3.12 picks the Python of a new environment)"
	@awk -F ':.*## ' '/^[a-z]+:.*## / { printf "  %-10s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

run: $(VENV)/with-ros ## start the cloth node and a scripted operator; Ctrl-C ends them
	@exec $(BIN)/cloth_run --scene '$(SCENE)' $(if $(DURATION),--duration '$(DURATION)')

test: lint ## check style and imports, run the tests
	$(BIN)/python -m pytest -n 2 --dist loadfile

gallery: $(VENV)/with-render ## draw every scene into docs/images
	$(BIN)/cloth_render --all --output docs/images

bench: $(VENV)/with-bench ## run every benchmark, the last two: beside the peers that are installed (BENCH=--quick: once), and bars
	@set -e; for script in $(filter-out %/table.py %/bars.py %/soak.py,$(wildcard benchmarks/*.py)); do echo "$$script"; $(BIN)/python "$$script"; done
	@echo benchmarks/table.py; $(BIN)/python benchmarks/table.py $(BENCH)
	@echo benchmarks/bars.py; $(BIN)/python benchmarks/bars.py

bars: $(VENV)/with-bench ## print every figure that is wanted of the solver beside its bar, in minutes
	$(BIN)/python benchmarks/bars.py

soak: $(VENV)/with-test $(VENV)/with-bench ## put the node through all that it has to stand, in two hours (SOAK='--seconds 20': short)
	$(BIN)/python benchmarks/soak.py $(SOAK)

peers: $(patsubst benchmarks/peers/requirements-%.txt,$(PEERS)/%/ready,$(wildcard benchmarks/peers/requirements-*.txt)) ## install the engines to compare with

validate: $(VENV)/with-ros ## compare the solver with the laws of physics
	$(BIN)/cloth_validate

lint: $(VENV)/with-test ## check style and imports
	$(BIN)/ruff check
	$(BIN)/lint-imports --no-logo

format: $(VENV)/with-test ## lay out the code
	$(BIN)/ruff check --fix
	$(BIN)/ruff format

clean: ## remove the environments, builds and caches
	rm -rf $(VENV) $(PEERS) build install log dist *.egg-info .pytest_cache .ruff_cache .hypothesis .import_linter_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# Each stamp says: these extras are installed, from this setup.py.
$(VENV)/with-test $(VENV)/with-render $(VENV)/with-bench: $(VENV)/with-ros
$(VENV)/with-%: $(VENV)/place setup.py pyproject.toml
	@echo "Installing the package with [$*] into $(VENV) (about a minute the first time) ..."
	@$(BIN)/python -m pip install -qq --editable '.[$*]'
	@touch $@

$(VENV)/place: | machine
	@echo "Making a Python environment in $(VENV) ..."
	@$(PYTHON) -m venv $(VENV)
	@echo '$(CURDIR)' > $@

# Peers pin versions of their own, so each has an environment of its own.
$(PEERS)/%/ready: benchmarks/peers/requirements-%.txt | machine
	@echo "Installing $* into $(PEERS)/$* ..."
	@$(PYTHON) -m venv $(PEERS)/$*
	@$(PEERS)/$*/bin/python -m pip install -qq --requirement $<
	@touch $@

.PHONY: machine
machine:
	@case "$$(uname -sm)" in "Linux x86_64") ;; *) \
	  echo "This needs Linux on x86_64 (the ROS wheels exist for nothing else); this machine is $$(uname -sm)." >&2; exit 1;; esac
	@command -v $(PYTHON) > /dev/null || { \
	  echo "There is no '$(PYTHON)' here. Try: sudo apt install python3 python3-venv, or PYTHON=/path/to/python." >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(not (3, 10) <= sys.version_info[:2] <= (3, 13))' || { \
	  echo "This needs Python 3.10 to 3.13; $(PYTHON) is $$($(PYTHON) -V 2>&1). Another one: make PYTHON=python3.12 ..." >&2; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2> /dev/null || { \
	  echo "This Python cannot make environments. Try: sudo apt install python3-venv" >&2; exit 1; }
