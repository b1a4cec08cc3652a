# The project's commands. `make survey` and `make test` need nothing but Python 3.11+ and make.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PYTEST := $(BIN)/python -m pytest --numprocesses=auto

INSTALL := -m pip install --quiet --disable-pip-version-check --editable

# What a release of a dependency can break: a part of the tests that calls all of them.
BROAD := tests/test_packaging.py tests/shaping/test_public_names.py \
	tests/shaping/optimal/test_linear_program.py tests/plant/test_linear_system.py \
	tests/plant/fmu/cosimulation tests/analysis/gate tests/analysis/test_command_line.py \
	tests/analysis/test_raw_output.py tests/analysis/test_units.py

.PHONY: survey test test-slow test-lowest test-newest check format benchmark readme clean

survey: $(VENV)/.installed
	$(BIN)/jounce survey examples/telescope.toml --output out/telescope

test: $(VENV)/.installed-dev
	$(PYTEST)

# The same tests with many more random problems, and without a fixed seed.
test-slow: $(VENV)/.installed-dev
	JOUNCE_TIER=slow $(PYTEST)

# Exactly the lowest releases that pyproject.toml admits, on the lowest Python; old releases warn
# of what newer ones of others have changed.
test-lowest:
	python=$$($(PYTHON) .ci/pythons.py oldest) && \
	if [ -z "$$python" ]; then echo "no Python as old as pyproject.toml admits: not tried"; else \
	"$$python" -m venv --clear $(VENV)-lowest && \
	$(PYTHON) .ci/lowest.py > $(VENV)-lowest/lowest.txt && \
	$(VENV)-lowest/bin/python $(INSTALL) ".[dev]" --no-compile --constraint $(VENV)-lowest/lowest.txt && \
	$(VENV)-lowest/bin/python -m pytest --numprocesses=auto -W ignore::DeprecationWarning $(BROAD); fi

# The newest releases that there are, on the newest Python of this machine.
test-newest:
	python=$$($(PYTHON) .ci/pythons.py newest) && "$$python" -m venv --clear $(VENV)-newest
	$(VENV)-newest/bin/python $(INSTALL) ".[dev]" --no-compile
	$(VENV)-newest/bin/python -m pytest --numprocesses=auto $(BROAD)

check: $(VENV)/.installed-dev .typing/jounce
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	cd .typing && ../$(BIN)/lint-imports ../pyproject.toml

# mypy sees the folders under the names that they are imported by; an sdist holds no links.
.typing/jounce:
	mkdir -p $@
	ln -s ../../jounce/__init__.py ../../jounce/py.typed $@
	ln -s $(filter-out ../../jounce,$(patsubst %/__init__.py,../../%,$(wildcard */__init__.py))) $@

format: $(VENV)/.installed-dev
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

readme: $(VENV)/.installed-dev
	$(BIN)/python docs/readme.py tree precision robustness picture
	$(BIN)/python docs/gallery.py

benchmark: $(VENV)/.installed-dev
	$(BIN)/python $(INSTALL) ".[benchmark,peers]"
	$(BIN)/python -m compileall -q jounce core shaping plant analysis # or imports are timed with their compilation
	$(BIN)/python docs/readme.py benchmarks

# The stamp files keep a second run from installing again.
$(VENV)/.installed: pyproject.toml setup.py
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python $(INSTALL) .
	$(BIN)/python -m compileall -q jounce core shaping plant analysis # pip does this only for what it copies
	touch $@

$(VENV)/.installed-dev: $(VENV)/.installed
	$(BIN)/python $(INSTALL) ".[dev]"
	touch $@

clean:
	rm -rf $(VENV) $(VENV)-lowest $(VENV)-newest out build dist .mypy_cache .pytest_cache .ruff_cache .hypothesis .import_linter_cache
