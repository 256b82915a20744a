# Everything runs from a virtual environment in .venv, made on first need from constraints.txt.

CANDIDATES := python3 python3.13 python3.12 python3.11
FITS = -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] < (3, 14))' 2>/dev/null
PYTHON ?= $(firstword $(foreach p,$(CANDIDATES),$(if $(filter ok,$(shell $(p) $(FITS) && echo ok)),$(p))))
BIN := .venv/bin
INSTALL := PYTHONWARNINGS=ignore $(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt

.PHONY: hawkmoth view test test-fast browser lint bench bench-view crash-test fuzz endurance mutants docs reports package clean

hawkmoth: .venv/.run  ## set up and run the main job
	$(BIN)/taichiflap simulate cases/hawkmoth.toml --overwrite
	@echo
	@echo "The result is hawkmoth.h5. Look at it with:"
	@echo "  make view                                 (wing and wake in the browser)"
	@echo "  $(BIN)/taichiflap info hawkmoth.h5    (its numbers)"
	@echo "  $(BIN)/taichiflap plot hawkmoth.h5    (figures for a paper)"

view: hawkmoth.h5  ## the result in the browser
	$(BIN)/taichiflap view hawkmoth.h5

hawkmoth.h5:
	@$(MAKE) hawkmoth

test: .venv/.dev browser  ## all tests, two files at a time, and what lines and branches they cover
	$(BIN)/python -m pytest -n 2 --dist loadfile --no-loadscope-reorder --cov

test-fast: .venv/.dev  ## the tests of a second or less each: half a minute
	$(BIN)/python -m pytest -n 2 --dist loadfile --no-loadscope-reorder -m "not slow"

browser:  ## Debian's chromium, for the tests that drive a browser
	@command -v chromium > /dev/null \
	|| { [ "$$(id -u)" = 0 ] && command -v apt-get > /dev/null && echo "Installing chromium ..." \
	     && apt-get -qq update > /dev/null && apt-get -qq install -y chromium > /dev/null; } \
	|| echo "*** There is no chromium: the BROWSER TESTS WILL BE SKIPPED. Install Debian's chromium to run them. ***"

lint: .venv/.dev  ## style and types
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

bench: .venv/.bench  ## speed, as ratios within one run to the hardware's limit and to peers; writes docs/benchmarks
	$(BIN)/python -m benchmarks

bench-view: .venv/.dev  ## the viewer: first picture, time a frame, ten browsers, explore, a large file
	$(BIN)/python -m benchmarks.view

crash-test: .venv/.dev  ## kill runs and exports at 100 random moments, refuse every write in turn, and look at what is left
	$(BIN)/python tests/crash.py 100
	$(BIN)/python tests/full_disk.py

fuzz: .venv/.dev  ## 20,000 wrong inputs and 2,000 damaged files: what becomes of them
	$(BIN)/python tests/fuzz.py 20000

endurance: .venv/.dev  ## a thousand beats, ten thousand cases, ten browsers for half an hour: an hour
	$(BIN)/python tests/endurance.py

mutants: .venv/.mutants  ## change the physics in pure Python in two thousand ways, and count what the tests notice
	$(BIN)/python tests/mutants.py

docs: .venv/.docs  ## the documentation, warnings as errors
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs docs/_build/html
	@echo "The documentation is docs/_build/html/index.html."

package: .venv/.dev  ## build it, and install it in clean environments of every Python here: minutes
	$(BIN)/python tests/package.py $(foreach p,python3.11 python3.12 python3.13,$(shell $(p) -c 'import sys; print(sys.executable)' 2>/dev/null))

reports: .venv/.run  ## write the reports among the documentation again, from their commands (minutes)
	$(BIN)/taichiflap validate -o build/validation --overwrite
	$(BIN)/taichiflap reproduce -o build/reproduction --overwrite
	$(BIN)/taichiflap score -o build/scores
	rm -f docs/validation-*.svg docs/reproduction/*.png docs/scores/*.png
	cp build/validation/validation.md build/validation/*.svg docs
	cp build/reproduction/report.md build/reproduction/models.md build/reproduction/*.png docs/reproduction
	mkdir -p docs/scores
	cp build/scores/scores.md build/scores/*.png docs/scores
	cp build/scores/known.json taichiflap/scored
	$(BIN)/python docs/gallery.py
	$(BIN)/python examples/frames.py docs/theory/frames.svg
	$(BIN)/python examples/two_wakes.py docs/two_wakes.png

clean:  ## remove the environment and what runs left here
	rm -rf .venv *.egg-info build dist mutants docs/_build docs/generated .pytest_cache .ruff_cache .mypy_cache .hypothesis
	rm -f *.h5 *.h5.part *.h5.state

.venv/bin/python:
	@test -n "$(PYTHON)" || { echo "taichiflap needs Python 3.11, 3.12 or 3.13; found none of $(CANDIDATES)"; exit 1; }
	@echo "Making .venv with $(PYTHON) ..."
	@$(PYTHON) -m venv .venv || { rm -rf .venv; echo "On Debian: apt-get install python3-venv"; exit 1; }

.venv/.run: .venv/bin/python pyproject.toml constraints.txt
	@echo "Installing taichiflap ..."
	@$(INSTALL) --editable .
	@touch $@

.venv/.docs: .venv/.run
	@echo "Installing the tools of the documentation ..."
	@$(INSTALL) --editable ".[docs]"
	@touch $@

.venv/.dev: .venv/.run
	@echo "Installing the tools of development ..."
	@$(INSTALL) --editable ".[cluster,dev,docs,video,xarray]"
	@touch $@

.venv/.mutants: .venv/.dev
	@$(INSTALL) --editable ".[mutants]"
	@touch $@

.venv/.bench: .venv/.run
	@echo "Installing the peers of the benchmarks ..."
	@$(INSTALL) --editable ".[bench]" || echo "*** numba could not be installed: ITS ROWS WILL BE MISSING. ***"
	@touch $@
