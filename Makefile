# make demo       simulate the default collision, write its results and pictures to demo/
# make test       the fast tests            make test-slow  the others too
# make bench      speed beside three plain programs of the same physics
# make docs       the site, in build/docs; open build/docs/index.html
# make explorer   the live model as one web page, build/explorer.html
# make wheel      what is published, in dist/: the sdist and this machine's wheel
# make lint       style, types, formatting  make format     lay the code out anew
#
# Each needs only python3 (with venv), make and a C++20 compiler; CMake and Ninja come from PyPI.
# Everything is installed into .venv, the package as a wheel like the one users get, and again when
# a source has changed. Without build isolation the compiler sees only what changed.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
WHEELS := build/wheel

SOURCES := pyproject.toml CMakeLists.txt README.md LICENSE \
    $(shell find include src -type f -not -path '*/__pycache__/*' -not -name page.html)
# A worker for each core, a file's tests on one worker: its fixtures are made once.
PARALLEL := -n auto --maxprocesses 8 --dist loadscope
CPP := $(shell find include src benchmarks -name '*.[ch]pp')
# The page of the explorer: part of what is tested, shown and published, not needed to try the package.
PAGE := src/pinchoff/explorer/page.html
WITH_PAGE := $(filter test test-slow docs explorer wheel,$(MAKECMDGOALS))

PY := src tests benchmarks examples docs/conf.py docs/_extensions

.PHONY: demo test test-slow bench bench-quick docs explorer wheel lint format clean

demo: $(VENV)/package.stamp
	$(BIN)/pinchoff run --out demo --overwrite

test: $(VENV)/test.stamp
	$(BIN)/python -m pytest $(PARALLEL) -m "not slow"

test-slow: $(VENV)/test.stamp
	$(BIN)/python -m pytest $(PARALLEL)

bench: $(VENV)/bench.stamp
	$(BIN)/python benchmarks/speed.py
	$(BIN)/python benchmarks/emulsion.py
	$(BIN)/python benchmarks/law.py
	$(BIN)/python benchmarks/chamber.py
	$(BIN)/python benchmarks/video.py

bench-quick: $(VENV)/bench.stamp
	$(BIN)/python benchmarks/speed.py --quick
	$(BIN)/python benchmarks/emulsion.py --quick
	$(BIN)/python benchmarks/law.py --quick
	$(BIN)/python benchmarks/chamber.py --quick
	$(BIN)/python benchmarks/video.py --quick

# All of it anew: pages that did not change would keep the old table of contents.
docs: $(VENV)/docs.stamp
	$(BIN)/sphinx-build -W --keep-going -q -E -a docs build/docs
	@echo "see build/docs/index.html"

explorer: $(VENV)/package.stamp
	$(BIN)/pinchoff explore --out build/explorer.html
	@echo "see build/explorer.html"

wheel: $(VENV)/test.stamp
	rm -rf dist
	$(BIN)/python -m build --outdir dist
	$(BIN)/python -m twine check --strict dist/*

lint: $(VENV)/lint.stamp
	$(BIN)/ruff check $(wildcard $(PY))
	$(BIN)/ruff format --check $(wildcard $(PY))
	$(BIN)/mypy
	$(BIN)/clang-format --dry-run -Werror $(CPP)

format: $(VENV)/lint.stamp
	$(BIN)/ruff check --fix-only $(wildcard $(PY))
	$(BIN)/ruff format $(wildcard $(PY))
	$(BIN)/clang-format -i $(CPP)

clean:
	rm -rf $(VENV) build demo dist benchmarks/results $(PAGE)

$(VENV)/venv.stamp:
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade "pip>=24"
	$(BIN)/python -c "import tomllib; \
	    print(*tomllib.load(open('pyproject.toml', 'rb'))['build-system']['requires'])" \
	    | xargs $(BIN)/python -m pip install --quiet cmake ninja
	touch $@

# The compiler is pinned: the same sources give the same page.
$(PAGE): $(VENV)/venv.stamp $(shell find include src/core src/explorer -type f -not -path '*/__pycache__/*')
	$(BIN)/python -m pip install --quiet ziglang==0.17.1
	$(BIN)/python src/explorer/build.py $@

# The wheel's name carries the version and the platform, so its folder holds this one only.
$(VENV)/package.stamp: $(VENV)/venv.stamp $(SOURCES) $(if $(WITH_PAGE),$(PAGE),$(wildcard $(PAGE)))
	rm -rf $(WHEELS)
	$(BIN)/python -m pip wheel --quiet --no-deps --no-build-isolation --wheel-dir $(WHEELS) .
	$(BIN)/python -m pip install --quiet --force-reinstall --no-deps $(WHEELS)/*.whl
	$(BIN)/python -m pip install --quiet $(WHEELS)/*.whl
	touch $@

# One extra each: test, lint, bench. The package itself is there already, from the same wheel.
$(VENV)/%.stamp: $(VENV)/package.stamp
	$(BIN)/python -m pip install --quiet "$$(echo $(WHEELS)/*.whl)[$(EXTRAS_$*)]"
	touch $@

EXTRAS_test := test,video,cluster,chamber
EXTRAS_bench := bench,chamber,video
EXTRAS_docs := docs,all
EXTRAS_lint := lint,test,video,chamber
