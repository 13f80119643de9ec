# Needs Python 3.11 or newer, make and git. Everything is installed into .venv in this folder.

BIN := .venv/bin
STAMP := .venv/stamp
JOBS ?= 2

# The first Python that is new enough; looked for only when there is something to install.
PYTHON ?= $(shell for p in python3 python3.14 python3.13 python3.12 python3.11 python; do \
	$$p -c 'import sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1 && { echo $$p; break; }; done)

# The scripts in a virtual environment hold its full path: one that was moved must be made anew.
ifneq ($(shell cat .venv/where 2>/dev/null),$(CURDIR))
$(shell rm -f $(STAMP))
endif

.PHONY: help install demo test bench docs lint clean

help:
	@echo "make demo     a move of an axis and its plot"
	@echo "make test     all tests; make test ARGS='-k trap' some of them"
	@echo "make install  only the environment: .venv/bin/scancycle"
	@echo "make bench    our code against C; writes benchmarks/RESULTS.md"
	@echo "make docs     the pages and charts of docs/blocks, docs/compliance.md"
	@echo "make lint     ruff"
	@echo "make clean    removes .venv"

# Bytecode is made here, too, for where PYTHONDONTWRITEBYTECODE is set: without it each start takes twice as long.
install: $(STAMP)
	@$(BIN)/python -m compileall -q stcore mclib plcruntime

$(STAMP): pyproject.toml requirements.lock
	@$(or $(PYTHON),false) -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || { \
		echo "scancycle needs Python 3.11 or newer; $(or $(PYTHON),python3) is: $$($(or $(PYTHON),python3) --version 2>&1)"; \
		echo "Install one, or name it: make $(firstword $(MAKECMDGOALS)) PYTHON=/path/to/python3"; exit 1; }
	@test "$$(cat .venv/where 2>/dev/null)" = "$(CURDIR)" || rm -rf .venv
	@echo "Installing into .venv with $$($(PYTHON) --version), once; less than a minute when downloads are quick"
	@test -x $(BIN)/pip || $(PYTHON) -m venv .venv
	@$(BIN)/pip install --quiet --disable-pip-version-check --no-deps --require-hashes -r requirements.lock
	@$(BIN)/pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	@echo "$(CURDIR)" > .venv/where
	@touch $@

demo: install
	@$(BIN)/scancycle demo

# Each process takes its tests one after the other and then from the others: they share what a file has loaded.
test: install
	@$(BIN)/python -m pytest -n $(JOBS) --dist worksteal -q $(ARGS)

bench: install
	@$(BIN)/python benchmarks/run.py $(ARGS)

docs: install
	@$(BIN)/python docs/make $(ARGS)

lint: install
	@$(BIN)/ruff check .

clean:
	rm -rf .venv
