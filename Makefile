# The project's commands. `make survey` and `make test` need nothing but Python 3.11+ and make.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PYTEST := $(BIN)/python -m pytest --numprocesses=auto

.PHONY: survey test test-slow check format benchmark readme clean

survey: $(VENV)/.installed
	$(BIN)/jounce survey examples/telescope.toml --output out/telescope

test: $(VENV)/.installed-dev
	$(PYTEST)

# The same tests with many more random problems, and without a fixed seed.
test-slow: $(VENV)/.installed-dev
	JOUNCE_TIER=slow $(PYTEST)

check: $(VENV)/.installed-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

format: $(VENV)/.installed-dev
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

readme: $(VENV)/.installed-dev
	$(BIN)/python docs/readme.py tree precision robustness picture
	$(BIN)/python docs/gallery.py

benchmark: $(VENV)/.installed-dev
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[benchmark,peers]"
	$(BIN)/python -m compileall -q shaping plant analysis # or imports are timed with their compilation
	$(BIN)/python docs/readme.py benchmarks

# The stamp files keep a second run from installing again.
$(VENV)/.installed: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable .
	$(BIN)/python -m compileall -q shaping plant analysis # pip does this only for what it copies
	touch $@

$(VENV)/.installed-dev: $(VENV)/.installed
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[dev]"
	touch $@

clean:
	rm -rf $(VENV) out build dist .mypy_cache .pytest_cache .ruff_cache .hypothesis .import_linter_cache
