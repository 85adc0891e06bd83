# Needs Python >= 3.11, make and git; everything else is installed into .venv,
# pinned and hash-checked. `make help` lists the targets.

PYTHON ?= python3
CORES  ?= 2
ARGS   ?=
RUN    ?= smoke

BIN    := .venv/bin
STAMP  := .venv/.stamp
IN_ENV := PATH="$(CURDIR)/$(BIN):$$PATH"
PIP    := $(BIN)/python -m pip install --quiet --disable-pip-version-check \
          --use-pep517 --no-build-isolation
WHEELS := --require-hashes --only-binary :all:
SNAKEMAKE := $(IN_ENV) snakemake --cores $(CORES)

# Wheels run no code when they are installed. One dependency comes as source only. It is built by the pinned setuptools, installed first:
# in an isolated build pip would fetch a setuptools that no hash vouches for.
LOCKED_SETUPTOOLS = awk '/^[^ ]/ { found = /^setuptools==/ } found' requirements.txt

.DEFAULT_GOAL := figures
.PHONY: figures figures-only smoke paper test lint docs verify checksums publish archive interruptions cache bench env \
        slurm lock clean help

figures: env  ## every figure, number and the report, standard lengths (default)
	$(SNAKEMAKE) $(ARGS)

smoke: env  ## the same in minutes, on short runs and coarse grids
	$(SNAKEMAKE) $(ARGS) --config preset=smoke

figures-only: env  ## the published figures again, without simulating, to build/figures; ARGS=fig12
	$(BIN)/python -m beltrepro.replication.report.excerpts $(ARGS)

paper: env  ## the same with the lengths of the paper: hours
	$(SNAKEMAKE) $(ARGS) --config preset=paper

test: env  ## the quick tests; ARGS="-m thorough" or ARGS="-m slow" for the others
	$(BIN)/python -m pytest --numprocesses $(CORES) --dist loadfile $(ARGS)

lint: env  ## style, imports, type hints, and the Snakemake files
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports --no-logo
	$(BIN)/mypy
	$(BIN)/snakefmt --check Snakefile workflow

docs: env  ## the site of the documentation, in build/site; a warning is an error
	$(IN_ENV) sphinx-build --quiet --fail-on-warning --keep-going docs build/site
	@echo "build/site/index.html"

verify: env  ## compare results with the published list; RUN=standard for another run than smoke
	$(BIN)/beltrepro verify results/$(RUN)

checksums: env  ## write that list anew from the results, after a change of numbers; RUN=standard
	$(BIN)/beltrepro verify results/$(RUN) --write

publish: env  ## report, article, figures, what they draw, claims of a run to docs/results, numbers to README; RUN=paper
	$(BIN)/python -m beltrepro.replication.report.publishing results/$(RUN)
	$(BIN)/beltrepro verify results/$(RUN) --write

archive:  ## sources of HEAD and a finished run in one ZIP file for a data repository; RUN=standard
	git archive --output=results/beltrepro-$(RUN).zip HEAD
	zip --quiet --recurse-paths results/beltrepro-$(RUN).zip results/$(RUN) --exclude '*/batches/*' '*/logs/*'

interruptions: env  ## kill the smoke workflow 20 times and compare the bits: half an hour
	$(BIN)/python tests/support/interruptions.py $(ARGS)

cache: env  ## compile the integrators now, not in the first runs
	$(BIN)/python -m beltrepro.extras.cache

bench: env  ## the speed of the integrators beside a plain loop in C: a minute
	$(BIN)/python benchmarks/bench.py $(ARGS)

env: $(STAMP)  ## .venv, from requirements.txt

$(STAMP): requirements.txt pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null \
	  || { echo "error: '$(PYTHON)' is not Python 3.11 or newer; try: make PYTHON=python3.12" >&2; exit 1; }
	$(PYTHON) -m venv .venv
	$(LOCKED_SETUPTOOLS) | $(PIP) $(WHEELS) -r /dev/stdin
	$(PIP) $(WHEELS) --no-binary connection-pool -r requirements.txt
	$(PIP) --no-index --no-deps -e .
	@touch $@

slurm: env  ## what Snakemake needs besides to send jobs to Slurm (docs/cluster.md)
	$(PIP) $(WHEELS) --no-deps -r requirements-slurm.txt
	$(BIN)/python -m pip check --disable-pip-version-check

LOCK := uv --no-config pip compile --quiet --universal --python-version 3.11 --generate-hashes \
        --no-emit-index-url --custom-compile-command "make lock" --upgrade

lock:  ## pin anew into requirements*.txt (needs uv on the PATH)
	$(LOCK) --all-extras pyproject.toml requirements.in -o requirements.txt
	$(LOCK) --no-deps requirements-slurm.in -o requirements-slurm.txt

clean:  ## remove .venv, caches and the smoke results; keep every other result
	rm -rf .venv .pytest_cache .ruff_cache .mypy_cache .import_linter_cache build dist results/smoke \
	  docs/reference docs/cookbook examples/*.h5
	find src tests workflow -name __pycache__ -prune -exec rm -rf {} +

help:  ## this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "%-13s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)
