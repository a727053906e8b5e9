# Everything runs in .venv, which is made from Python alone.
PYTHON ?= python3
BIN := .venv/bin
BASE := .venv/.base
STAMP := .venv/.installed
PIP := $(BIN)/python -m pip install --quiet --constraint constraints.txt --editable

.PHONY: demo test test-slow lint format reproduce bench bench-system bench-gpu vision-system tables tutorials docs clean

demo: $(BASE)
	$(BIN)/motorspace demo --out demo

test: lint
	$(BIN)/python -m pytest

test-slow: $(STAMP)
	$(BIN)/python -m pytest -m slow

lint: $(STAMP)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports

format: $(STAMP)
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

reproduce: $(STAMP)
	$(BIN)/motorspace reproduce all --budget paper --out runs/paper

# Side by side with other software, which has a folder of its own.
bench: .venv-bench/.installed
	.venv-bench/bin/python -m benchmarks
	.venv-bench/bin/python -m docs.tables

# On a device: needs JAX with CUDA in the environment; without a GPU it says so and ends.
bench-gpu: $(STAMP)
	$(BIN)/python -m benchmarks.gpu
	$(BIN)/python -m docs.tables

# What Open3D and the measurement of the peak need from the system.
bench-system:
	apt-get install --yes libusb-1.0-0 libgl1 gcc

# What MiniWorld needs from the system to draw without a screen.
vision-system:
	apt-get install --yes libegl1 libfreetype6 libgl1 libgl1-mesa-dri libglu1-mesa

.venv-bench/.installed: pyproject.toml constraints.txt
	$(PYTHON) -m venv .venv-bench
	.venv-bench/bin/python -m pip install --quiet --constraint constraints.txt --editable '.[bench]'
	touch $@

# The tables and figures of results in the documentation, from the files in results/.
tables: $(STAMP)
	$(BIN)/python -m docs.tables

# The pages of the tutorials: text, code, what it prints and draws; and the pictures that show a
# trained network. Takes some ten minutes.
tutorials: $(STAMP)
	$(BIN)/python -m docs.run_tutorials
	$(BIN)/python -m docs.portraits

# The site in site/index.html. Broken links, missing names and pictures, and anything that a page
# would load from the network fail.
docs: $(STAMP)
	$(BIN)/python -m docs.drawings
	$(BIN)/python -m docs.reference
	$(BIN)/zensical build --strict --clean
	$(BIN)/python -m docs.check site

clean:
	rm -rf .venv .venv-bench demo build dist site

$(STAMP): $(BASE)
	$(PIP) '.[dev]'
	touch $@

$(BASE): pyproject.toml constraints.txt
	$(PYTHON) -m venv .venv
	$(PIP) .
	touch $@
