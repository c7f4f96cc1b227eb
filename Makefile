# Every target sets up what it needs in .venv; nothing is installed elsewhere.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# uv takes a third of the time. If it fails (no wheel of it, an index that only pip's settings name), pip installs.
PIP = packages() { $(BIN)/uv pip install --quiet --python $(BIN)/python "$$@" 2> /dev/null \
  || $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile "$$@"; }; packages
LOWEST := $(VENV)-lowest
RECORDINGS ?= articulography
TEXTS ?= text
DICTIONARIES ?= dictionaries
DATA ?= data

# npm packages that read what we write; tests that need them skip, and say so, where they are missing
CONSUMERS := $(VENV)/node
export LIPSYNC_LANG_NODE_MODULES ?= $(abspath $(CONSUMERS)/node_modules)

.PHONY: atheris findings help demo test test-rest test-all test-windows sanitize test-lowest consumers usd lint prose types bench articulography motion languages dictionaries figures paper gallery docs wheel extras clean

help: ## list the targets
	@grep -E '^[a-z-]+:.*##' Makefile | sed -e 's/:.*##/\t/' | expand -t 16

# The pip at hand fetches the newest one, which is quicker and smaller than the pip that venv unpacks.
# If that fails (no pip, or one before 22.3), venv unpacks its own.
$(BIN)/python:
	$(PYTHON) -c 'import sys; sys.exit("Python 3.11 or newer is needed: make PYTHON=python3.12") if sys.version_info < (3, 11) else 0'
	$(PYTHON) -m venv --without-pip $(VENV)
	@$(PYTHON) -m pip --quiet --python $@ install --no-compile pip uv 2> /dev/null || $(PYTHON) -m venv $(VENV)

# If there is a C compiler, an editable install builds the compiled kernel in place.
KERNEL := hatch_build.py lipsync_lang/pipeline/kernel.c

$(VENV)/demo: pyproject.toml $(KERNEL) | $(BIN)/python
	@$(PIP) --editable '.[speech,plot,studio]'
	touch $@

$(VENV)/ready: pyproject.toml $(KERNEL) | $(BIN)/python
	@$(PIP) --editable '.[all,whisper,dev,docs]'
	touch $(VENV)/demo $(VENV)/docs $@

$(VENV)/docs: pyproject.toml $(KERNEL) | $(BIN)/python
	@$(PIP) --editable '.[docs]'
	touch $@

demo: $(VENV)/demo ## speak a sentence and draw how its curves were made
	@mkdir -p out
	@PYTHONDONTWRITEBYTECODE=1 $(BIN)/lipsync-lang run "Please buy five more maps before Bob moves away." \
	  -l english -c facefx -o out/demo.html -o out/demo.wav -o out/demo.json -o out/demo.csv \
	  --plot out/demo.png
	@echo
	@echo "Open out/demo.html in a browser: the head speaks, and every curve gives its reasons."
	@echo "out/demo.wav is the sound, and out/demo.png every curve, stage by stage."
	@echo "out/demo.csv and out/demo.json are the animation, 60 frames a second."
	@echo "Shape it in the studio:"
	@echo "  $(BIN)/lipsync-lang studio -l english -c crab"
	@echo "Next, try a sentence of your own, or ask why the mouth has this shape:"
	@echo "  $(BIN)/lipsync-lang run \"Hello, world\" -l english -c facefx -o out/hello.csv --plot out/hello.png"
	@echo "  $(BIN)/lipsync-lang explain \"Hello, world\" -l english -c facefx --at 0.42"

test: $(VENV)/ready ## run the quick tests
	$(BIN)/python -m pytest -n auto --dist worksteal -m "not full"

# All tests that `test` leaves out, and every property once more with seven times the examples. Tests with an `xdist_group`
# share a costly setup, so one worker runs them.
test-rest: $(VENV)/ready
	$(BIN)/python -m pytest -n auto --dist loadgroup -m "full or hypothesis" --hypothesis-profile=full

test-all: test test-rest ## run all tests

# Rooms that touch files, processes and pipes; other folders of tests are named by ROOMS.
ROOMS ?= base/files text/lines plugins/cluster production packs/banks plugins/study plugins/mfa
test-windows: $(VENV)/ready ## run quick tests as Windows would: make test-windows ROOMS="base/files text/lines"
	PYTHONPATH=tests $(BIN)/python -m pytest -n auto --dist worksteal -p windows_lane -m "not full" $(addprefix tests/,$(ROOMS))

sanitize: $(VENV)/ready ## run the compiled kernel and a fuzz of its arguments under ASan and UBSan
	$(BIN)/python -m pytest tests/pipeline/test_sanitized_kernel.py

# The lowest version of every direct dependency: what pyproject.toml promises, in a venv of its own.
# Old releases call what newer releases of their own dependencies have deprecated: no fault of ours.
test-lowest: pyproject.toml ## run the quick tests with the lowest versions allowed: make test-lowest PYTHON=python3.11
	$(PYTHON) -m venv $(LOWEST)
	$(LOWEST)/bin/python -m pip install --quiet --disable-pip-version-check uv
	$(LOWEST)/bin/uv pip compile --quiet --resolution lowest-direct --all-extras --python $(LOWEST)/bin/python \
	  --output-file $(LOWEST)/versions.txt pyproject.toml
	$(LOWEST)/bin/python -m pip install --quiet --disable-pip-version-check \
	  --requirement $(LOWEST)/versions.txt --editable .
	$(LOWEST)/bin/python -m pytest -n auto --dist worksteal -m "not full" -W default::DeprecationWarning

consumers: $(CONSUMERS)/fetched ## fetch what reads GLB in the tests (npm); a browser is not fetched

$(CONSUMERS)/fetched: tests/browser/package.json
	mkdir -p $(CONSUMERS)
	cp tests/browser/package.json $(CONSUMERS)/
	npm install --silent --no-audit --no-fund --prefix $(CONSUMERS)
	touch $@

usd: $(VENV)/usd ## fetch the library of USD, which reads .usda in the tests (pip, 209 MB)

$(VENV)/usd: | $(VENV)/ready
	@$(PIP) usd-core
	touch $@

atheris: $(VENV)/atheris ## fetch what lets coverage guide the fuzzing (pip, Linux)

$(VENV)/atheris: | $(VENV)/ready
	@$(PIP) atheris
	touch $@

lint: $(VENV)/ready ## check style
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/check-jsonschema --builtin-schema vendor.github-workflows .github/workflows/*.yml
	$(BIN)/zizmor --quiet --offline .github

prose: $(VENV)/ready ## check the words of pages, messages, scripts and packs: make prose FILES=README.md
	$(BIN)/python tests/prose/lint.py $(FILES)

types: $(VENV)/ready ## check types
	$(BIN)/mypy

bench: $(VENV)/ready ## print how fast things are: make bench SECTION=stream LINES=10000 JSON=file AGAINST=revision
	$(BIN)/python benchmarks/speed.py $(SECTION:%=--only %) $(LINES:%=--lines %) $(JSON:%=--json %) $(AGAINST:%=--against %)

articulography: $(VENV)/ready ## compare curves with recordings of real mouths: make articulography RECORDINGS=folder
	$(BIN)/python benchmarks/articulography.py $(RECORDINGS)

front: $(VENV)/ready ## compare our lips with filmed ones: make front FILMS=folder HEADS="head.glb other.glb" TRACKER=python RENDER=1
	$(BIN)/python benchmarks/face_on.py $(FILMS) $(HEADS:%=-c %) $(TRACKER:%=--tracker %) $(RENDER:%=--render)

motion: $(VENV)/ready ## print how curves move, beside captures: make motion RECORDINGS=folder
	$(BIN)/python benchmarks/motion.py $(RECORDINGS) --contacts

languages: $(VENV)/ready ## print how every language reads: make languages TEXTS=folder
	$(BIN)/python benchmarks/languages.py $(TEXTS)

dictionaries: $(VENV)/ready ## count readings that differ from dictionaries: make dictionaries DICTIONARIES=folder
	$(BIN)/python benchmarks/dictionaries.py $(DICTIONARIES)

figures: $(VENV)/ready ## measure "How good is it?" again: make figures DATA=folder DICTIONARIES=folder HEADS=folder
	$(BIN)/python docs/measure.py $(DATA) --dictionaries $(DICTIONARIES) $(HEADS:%=--heads %)
	$(BIN)/python docs/how_good.py

paper: $(VENV)/ready ## make the paper's tables and figures again, into out/paper: make paper CLIPS=1 renders a study too
	$(BIN)/python docs/draw_paper.py $(CLIPS:%=--clips) out/paper

gallery: $(VENV)/ready ## draw every pose set as it says one line
	$(BIN)/python docs/draw_gallery.py

docs: $(VENV)/docs ## build the documentation site into build/site
	@NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --quiet
	@echo "Open build/site/index.html in a browser."

wheel: $(VENV)/ready ## build the wheel and the source archive into dist/, and check their descriptions
	$(BIN)/python -m build
	$(BIN)/twine check --strict dist/*

extras: $(VENV)/ready ## measure the size of each extra for the page on installation (20 minutes): make extras EXTRAS="plot audio"
	$(BIN)/python docs/measure_extras.py $(EXTRAS)

# They install pinned packages of others from PyPI and npm, and run nothing of ours.
findings: ## check what libraries of others do unexpectedly (needs a network, python3 and npm)
	@for script in findings/*.sh; do echo "$$script"; bash "$$script" || exit 1; done

clean: ## remove what was built
	rm -rf $(VENV) $(LOWEST) build dist out
