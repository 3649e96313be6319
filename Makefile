# `make` lists what there is. Needs python3 >= 3.11 and make; everything else goes into .venv.
PYTHON ?= python3
BIN := .venv/bin
INSTALLED := .venv/installed

.DEFAULT_GOAL := help
.PHONY: help demo test lint figures adapter clean

help:
	@echo "make demo      render the atrium to out/demo.png and print what each stage costs"
	@echo "make test      ruff, mypy and the tests"
	@echo "make lint      ruff and mypy"
	@echo "make figures   measure every figure the project claims"
	@echo "make clean     remove .venv, out and caches"
	@echo "PYTHON=...     which Python makes .venv (default: python3)"

demo: adapter
	@mkdir -p out
	$(BIN)/octolux render atrium --size 1280x720 --frames 3 --out out/demo.png --stats out/demo.json

test: lint adapter
	$(BIN)/python -m pytest

lint: $(INSTALLED)
	$(BIN)/ruff check .
	$(BIN)/mypy

figures: adapter
	$(BIN)/python -m benchmarks

adapter: $(INSTALLED)
	@sh scripts/ensure_adapter.sh $(BIN)/octolux

# Made anew when pyproject.toml changed; the package itself is installed editable.
$(INSTALLED): pyproject.toml
	@sh scripts/ensure_python.sh "$(PYTHON)"
	@echo "installing octolux and its tools into .venv"
	@"$(PYTHON)" -m venv .venv
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[dev]"
	@touch $@

clean:
	rm -rf .venv out build dist *.egg-info .pytest_cache .ruff_cache .mypy_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
