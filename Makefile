# smidgen: `make demo` shows everything, `make test` checks it. Both install what is missing.
PYTHON ?= python3
VENV   := .venv
PY     := $(VENV)/bin/python
# Bytecode lies beside the environment, not among the sources, and is kept: the tests start many interpreters.
KEEPING := PYTHONDONTWRITEBYTECODE= PYTHONPYCACHEPREFIX="$(CURDIR)/$(VENV)/bytecode" $(PY)
PREFIX ?= /usr/local
# A manual page from the options of the command; docs/manual.txt adds what they do not say.
MANUAL := argparse-manpage --module smidgen.cli.parser --function make_parser --prog smidgen --project-name smidgen --manual-title smidgen \
  --description "compile Hamiltonians to structure-preserving integrators" --version "$$(sed -n 's/^version = "\(.*\)"/\1/p' pyproject.toml)" \
  --format single-commands-section --include docs/manual.txt
PAGE   := out/smidgen.1
PYTEST := $(KEEPING) -m pytest -n 2 --dist worksteal

.PHONY: demo install site manual test quick test-long bench bench-scenes hard mutants coverage fuzz fuzz-specs fuzz-scenes frozen imports files clean

demo: $(VENV)/ready
	$(PY) -m smidgen.show.demo --out out/demo

# The pages of docs/ as a site that needs no network (open out/site/index.html), and the manual page (man -l out/smidgen.1).
site: $(VENV)/ready-site
	$(PY) -m sphinx -q -W --keep-going -b html docs out/site
	$(MAKE) manual

manual:
	@mkdir -p "$(dir $(PAGE))"
	$(VENV)/bin/$(MANUAL) --output "$(PAGE)"

test: $(VENV)/ready-test
	$(PYTEST) -m "not long and not slow"

quick: $(VENV)/ready-test
	$(PYTEST) -m quick

test-long: $(VENV)/ready-site
	$(PYTEST)

# The command with its Python packages, manual page, and CMake's file below PREFIX.
install:
	$(PYTHON) -m venv "$(PREFIX)/lib/smidgen"
	"$(PREFIX)/lib/smidgen/bin/pip" install --quiet --disable-pip-version-check ".[hdf5,pictures]"
	"$(PREFIX)/lib/smidgen/bin/pip" install --quiet --disable-pip-version-check --constraint requirements-site.txt argparse-manpage
	mkdir -p "$(PREFIX)/bin" "$(PREFIX)/lib/cmake/smidgen" "$(PREFIX)/share/man/man1"
	ln -sf "$(PREFIX)/lib/smidgen/bin/smidgen" "$(PREFIX)/bin/smidgen"
	cp gen/cmake/smidgen-config.cmake "$(PREFIX)/lib/cmake/smidgen/"
	"$(PREFIX)/lib/smidgen/bin/"$(MANUAL) --output "$(PREFIX)/share/man/man1/smidgen.1"

bench: $(VENV)/ready
	$(PY) tests/bench/run.py

# What an additional effect costs, compared with exchange alone (some minutes); writes docs/beside_exchange.md. TIMES=1: times too, and
# those at neighbouring points, on a machine without other work.
bench-scenes: $(VENV)/ready
	$(PY) tests/bench/beside_exchange.py $(if $(TIMES),--times)
	$(if $(TIMES),$(PY) tests/bench/neighbours.py)

$(VENV)/ready: tests/install.sh requirements.txt requirements-test.txt pyproject.toml setup.py
	PYTHON="$(PYTHON)" sh tests/install.sh $(VENV)
	@touch $@

# The hard cases, one by one, beside what each must show; writes docs/hard.md. TIER=quick or long: one tier, printed only.
hard: $(VENV)/ready-test
	PYTHONPATH=tests $(PY) -m hard.table $(if $(TIER),--tier $(TIER))

# Faults planted one at a time, and the tests that notice them (an hour; goes on where it was stopped); writes docs/mutants.md.
mutants: $(VENV)/ready-test
	$(PY) tests/mutants/run.py

# Which branches of runtime/ the tests take (some minutes); writes docs/coverage.md.
coverage: $(VENV)/ready-test
	$(PY) tests/covered/run.py

# Which integrators have other bits than before a change? UPDATE=1 first, before it; then without. A quarter of an hour each.
frozen: $(VENV)/ready-test
	$(PY) tests/frozen/run.py $(if $(UPDATE),--update)

# Which room of gen/ imports which: the picture in docs/architecture.md.
imports: $(VENV)/ready
	$(PY) tests/support/imports.py --write

# Every source file with the first sentence of its comment: docs/files.md.
files: $(VENV)/ready
	$(PY) tests/support/file_index.py --write

# Random specs, Hamiltonians and steps for MINUTES; what they find lies in out/fuzz, what reaches new code joins the corpus.
fuzz: $(VENV)/ready-test
	$(PY) -m pip install --quiet -r tests/fuzz/requirements.txt
	cd tests && ../$(PY) -m fuzz.run --minutes $(or $(MINUTES),10) $(if $(SEED),--seed $(SEED))

# COUNT random specs from SEED on through compilers, sanitizers and witness, two at a time (an hour for a thousand; goes on where it was stopped);
# writes docs/fuzz_specs.csv and its tables in docs/fuzzing.md.
fuzz-specs: $(VENV)/ready-test
	cd tests && ../$(PY) -m fuzz.specs --count $(or $(COUNT),1000) --seed $(or $(SEED),0) --jobs 2; found=$$?; \
	../$(PY) -m fuzz.table ../out/fuzz/specs.csv --count $(or $(COUNT),1000) --seed $(or $(SEED),0) && exit $$found

# The same for scenes: bases, switched effects, pieces, tables of numbers; writes docs/fuzz_scenes.csv and its tables.
fuzz-scenes: $(VENV)/ready-test
	cd tests && ../$(PY) -m fuzz.specs --scenes --count $(or $(COUNT),1000) --seed $(or $(SEED),0) --jobs 2; found=$$?; \
	../$(PY) -m fuzz.table ../out/fuzz/scenes.csv --scenes --count $(or $(COUNT),1000) --seed $(or $(SEED),0) && exit $$found

# What only the tests use: other compilers, a browser. Tests say so when one is missing. What both of their processes import is compiled once.
$(VENV)/ready-test: $(VENV)/ready
	sh tests/install.sh --extras
	@$(KEEPING) -c "import sympy, matplotlib.pyplot, scipy.integrate, scipy.stats, hypothesis, h5py, dask.distributed"
	@touch $@

$(VENV)/ready-site: $(VENV)/ready-test requirements-site.txt
	$(PY) -m pip install --quiet --disable-pip-version-check -r requirements-site.txt
	@touch $@

clean:
	rm -rf $(VENV) build out dist *.egg-info .pytest_cache .hypothesis
