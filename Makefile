# The project's commands. `make survey` and `make test` need nothing but Python 3.11+ and make.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# Workers take their tests in the order of the files, so that few prepare the same twice.
XDIST := --numprocesses=auto --dist=worksteal
PYTEST := $(BIN)/python -m pytest $(XDIST)

# Else every process of a test would compile what it imports again.
unexport PYTHONDONTWRITEBYTECODE

INSTALL := -m pip install --quiet --disable-pip-version-check --editable

# What a release of a dependency can break: a part of the tests that calls all of them.
BROAD := tests/test_packaging.py tests/test_public_names.py \
	tests/shaping/optimal/test_linear_program.py tests/plant/test_linear_system.py \
	tests/fmu/cosimulation tests/app/gate tests/app/test_command_line.py \
	tests/app/test_raw_output.py tests/app/test_units.py

.PHONY: survey test test-slow test-browser test-sanitize test-lowest test-newest check check-core wheel format
.PHONY: benchmark readme docs docs-pages docs-links clean

survey: $(VENV)/.installed
	$(BIN)/jounce survey examples/telescope.toml --output out/telescope

test: $(VENV)/.installed-dev
	$(PYTEST)

# The same tests with many more random problems, and without a fixed seed.
test-slow: $(VENV)/.installed-dev
	JOUNCE_TIER=slow $(PYTEST)

# The explorer's whole page, in Chromium, which has to be on the path.
test-browser: $(VENV)/.installed-dev
	JOUNCE_BROWSER=required $(BIN)/python -m pytest tests/app/explorer/test_page.py tests/app/explorer/test_whole_page.py

# Random problems in C under sanitizers; what fails is printed so that Python can try it.
CC := $(or $(shell command -v gcc || command -v clang),$(BIN)/python -m ziglang cc)
CORE := $(filter-out core/binding.c,$(wildcard core/*.c))
STRICT := -std=c99 -ffp-contract=off -Wall -Wextra -Wconversion -Wshadow -Werror
test-sanitize: out/driver out/driver_loops
	out/driver
	out/driver_loops

out/driver out/driver_loops: out/%: tests/core/%.c $(CORE) $(wildcard core/*.h)
	mkdir -p out
	$(CC) $(STRICT) -Wpedantic -g -O1 -fsanitize=address,undefined -fno-sanitize-recover=all \
		-Icore -o $@ tests/core/$*.c $(CORE)

# Exactly the lowest releases that pyproject.toml admits, on the lowest Python; old releases warn
# of what newer ones of others have changed.
test-lowest: $(VENV)-lowest/.installed
	if [ -x $(VENV)-lowest/bin/python ]; then \
	$(VENV)-lowest/bin/python -m pytest $(XDIST) -W ignore::DeprecationWarning $(BROAD); fi

$(VENV)-lowest/.installed: pyproject.toml setup.py $(wildcard core/*.c core/*.h)
	rm -rf $(VENV)-lowest && mkdir $(VENV)-lowest
	python=$$($(PYTHON) .ci/pythons.py oldest) && \
	if [ -z "$$python" ]; then echo "no Python as old as pyproject.toml admits: not tried"; else \
	"$$python" -m venv $(VENV)-lowest && \
	$(PYTHON) .ci/lowest.py > $(VENV)-lowest/lowest.txt && \
	$(VENV)-lowest/bin/python $(INSTALL) ".[dev]" --no-compile --constraint $(VENV)-lowest/lowest.txt; fi
	touch $@

# The newest releases that there are, on the newest Python of this machine; `make clean` forgets
# those of the last time.
test-newest: $(VENV)-newest/.installed
	$(VENV)-newest/bin/python -m pytest $(XDIST) $(BROAD)

$(VENV)-newest/.installed: pyproject.toml setup.py $(wildcard core/*.c core/*.h)
	python=$$($(PYTHON) .ci/pythons.py newest) && "$$python" -m venv --clear $(VENV)-newest
	$(VENV)-newest/bin/python $(INSTALL) ".[dev]" --no-compile
	touch $@

check: $(VENV)/.installed-dev .typing/jounce check-core
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	cd .typing && ../$(BIN)/lint-imports ../pyproject.toml

# mypy sees the folders under the names that they are imported by; an sdist holds no links.
.typing/jounce:
	mkdir -p $@
	ln -s $(addprefix ../../,$(wildcard jounce/*.py) jounce/py.typed) $@
	ln -s $(filter-out ../../jounce,$(patsubst %/__init__.py,../../%,$(wildcard */__init__.py))) $@

# ISO C has no word for the slots of Python's types, so that the binding is not pedantic.
check-core: $(VENV)/.installed-dev
	mkdir -p out
	set -e; for file in $(CORE); do $(CC) $(STRICT) -Wpedantic -O2 -c $$file -o out/core.o; done
	$(CC) $(STRICT) -O2 -DPy_LIMITED_API=0x030B0000 -c core/binding.c -o out/core.o \
		-isystem $$($(BIN)/python -c "import sysconfig; print(sysconfig.get_path('include'))")
	$(BIN)/cppcheck --quiet --std=c99 --enable=warning,performance,portability \
		--error-exitcode=1 --inline-suppr $(CORE)

# One wheel for all Pythons from 3.11 on, tried where there is no compiler.
wheel: $(VENV)/.installed
	rm -rf dist
	$(BIN)/python -m pip wheel --quiet --disable-pip-version-check --no-deps --wheel-dir dist .
	$(BIN)/python building/try_wheel.py dist/jounce-*.whl

format: $(VENV)/.installed-dev
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

readme: $(VENV)/.installed-dev
	$(BIN)/python docs/readme.py tree precision robustness picture
	$(BIN)/python docs/gallery.py

benchmark: $(VENV)/.installed-dev
	$(BIN)/python $(INSTALL) ".[benchmark,explore,peers]"
	$(BIN)/python -m compileall -q jounce core shaping plant fmu analysis plots app # or imports are timed with their compilation
	$(BIN)/python docs/readme.py benchmarks

# The site, in out/site; a page that is not right ends it.
docs: $(VENV)/.installed-docs
	$(BIN)/python -m sphinx -q -W --keep-going -b html docs out/site

# The same without running the notebooks, which a test does anyway.
docs-pages: $(VENV)/.installed-docs
	$(BIN)/python -m sphinx -q -W --keep-going -D nb_execution_mode=off -b html docs out/pages

# Whether what pages lead to elsewhere is there; needs the internet.
docs-links: $(VENV)/.installed-docs
	$(BIN)/python -m sphinx -q --keep-going -D nb_execution_mode=off -b linkcheck docs out/links

# The stamp files keep a second run from installing again.
$(VENV)/.installed: pyproject.toml setup.py $(wildcard core/*.c core/*.h)
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python $(INSTALL) .
	$(BIN)/python -m compileall -q jounce core shaping plant fmu analysis plots app # pip does this only for what it copies
	touch $@

$(VENV)/.installed-dev: $(VENV)/.installed
	$(BIN)/python $(INSTALL) ".[dev]"
	touch $@

$(VENV)/.installed-docs: $(VENV)/.installed
	$(BIN)/python $(INSTALL) ".[docs]"
	touch $@

clean:
	rm -rf $(VENV) $(VENV)-lowest $(VENV)-newest out build dist .mypy_cache .pytest_cache .ruff_cache .hypothesis .import_linter_cache
