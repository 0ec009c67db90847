# make run     the main job, on a fresh machine with python3
# make test    its own set-up, then lint, types, import layers and tests
# make lint    the checks alone
# make wheel   the wheel in dist, with its kernels' machine code, and in new environments: the main job, and an
#              export on other Pythons that are here
# make docs    the site in build/docs, with every notebook and command of its pages run; docs-pages: without
# make bench   every benchmark, and one table of them in benchmarks/results (BENCH_FLAGS=--quick for short ones)
# make clean   remove everything that make made

PYTHON ?= python3
BENCH_FLAGS ?=
# Processes of the tests: one a core, up to four, each of which imports and collects all of them.
WORKERS ?= $(shell cores=$$(nproc 2>/dev/null || echo 2); echo $$((cores < 4 ? cores : 4)))
VENV := .venv
BIN := $(VENV)/bin
PACKAGES := circuits chips netlists system
PICTURE := approach.png

# Stamps: an install is repeated only when pyproject.toml changed. Both are editable, so sources need none.
RUN_READY := $(VENV)/.run-ready
TEST_READY := $(VENV)/.test-ready

# Empty for root, sudo where it asks nothing, else a command that fails.
AS_ROOT = $(shell if [ "$$(id -u)" = 0 ]; then :; elif sudo -n true 2>/dev/null; then echo sudo -n; else echo false; fi)
APT = $(AS_ROOT) env DEBIAN_FRONTEND=noninteractive apt-get -q
HAS_APT = command -v apt-get >/dev/null

# Byte code, that of the tests' asserts too, is kept whatever the user's setting, beside its source, where pip
# keeps that of what it installs: without it each worker, and each process that a test starts, compiles it anew.
# A file's tests go to one worker, with what they share.
KEEP_BYTE_CODE := PYTHONDONTWRITEBYTECODE= PYTHONPYCACHEPREFIX=
# In CI pip compiles nothing: three quarters of what it installs for the tests is never imported.
NO_BYTE_CODE = $(if $(filter true,$(CI)),--no-compile)
# Linear algebra has one thread: those that wait for a small matrix take the core of the other worker.
PYTEST = $(KEEP_BYTE_CODE) MPLBACKEND=Agg OPENBLAS_NUM_THREADS=1 $(BIN)/pytest -n $(WORKERS) --dist loadfile

HAS_BROWSER = command -v chromium >/dev/null && command -v chromedriver >/dev/null

LOAD_NGSPICE = $(BIN)/python -c 'import ctypes, ctypes.util, os; \
	ctypes.CDLL(os.environ.get("NGSPICE_LIBRARY_PATH") or ctypes.util.find_library("ngspice") or "libngspice.so.0")' \
	2>/dev/null

# Every page is read anew: Sphinx takes a page that has not changed as it was read before, with what its commands
# said then, and without the error that it was read with. Commands and notebooks are kept beside, by what they run.
SITE = $(KEEP_BYTE_CODE) $(BIN)/sphinx-build -q -W --keep-going -E -b html

.PHONY: run test checks lint wheel ngspice browser docs docs-pages bench clean
.DELETE_ON_ERROR:

run: $(RUN_READY)
	$(BIN)/noctule run approach --beside nominal --plot $(PICTURE)
	@echo "The picture is $(CURDIR)/$(PICTURE)"

test: $(TEST_READY)
	@$(MAKE) -j 2 checks
	$(PYTEST)

# What takes one core each goes side by side.
checks: ngspice browser lint docs-pages

lint: $(TEST_READY)
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy --strict $(PACKAGES)
	$(BIN)/lint-imports

wheel: $(TEST_READY)
	$(KEEP_BYTE_CODE) $(BIN)/python benchmarks/wheel.py --ci --output dist

# A path that the user set is the user's: apt would not mend it.
ngspice: $(TEST_READY)
	@$(LOAD_NGSPICE) || { [ -z "$$NGSPICE_LIBRARY_PATH" ] && $(HAS_APT) \
		&& $(APT) update && $(APT) install -y --no-install-recommends libngspice0; } || true
	@$(LOAD_NGSPICE) || { \
		echo "ngspice's shared library was not found: install Debian's libngspice0," \
			"or set NGSPICE_LIBRARY_PATH to the full path of libngspice.so" >&2; \
		if [ "$$CI" = true ]; then echo "in CI this is a failure" >&2; exit 1; fi; \
		echo "going on: what needs ngspice is skipped" >&2; }

# Debian's browser and what drives it open the pages of runs. After ngspice, since apt serves one at a time.
browser: ngspice
	@$(HAS_BROWSER) || { $(HAS_APT) \
		&& $(APT) update && $(APT) install -y --no-install-recommends chromium chromium-driver; } || true
	@$(HAS_BROWSER) || { \
		echo "chromium and chromedriver were not found: install Debian's chromium and chromium-driver" >&2; \
		if [ "$$CI" = true ]; then echo "in CI this is a failure" >&2; exit 1; fi; \
		echo "going on: what needs a browser is skipped" >&2; }

docs: ngspice
	$(BIN)/noctule run approach --beside nominal --plot docs/approach.png
	$(SITE) -D noctule_run=1 -D nb_execution_mode=cache -d build/docs-read docs build/docs
	$(PYTEST) -q tests/test_documents.py tests/test_examples.py tests/system/cli/test_json_keys.py --documents=all
	@echo "The site is $(CURDIR)/build/docs/index.html"

docs-pages: $(TEST_READY)
	$(SITE) -d build/docs-pages-read docs build/docs-pages

bench: $(TEST_READY)
	$(BIN)/python benchmarks/table.py $(BENCH_FLAGS)

clean:
	rm -rf $(VENV) build dist circuits/machine_code/shipped .hypothesis .import_linter_cache .mypy_cache .pytest_cache .ruff_cache $(PICTURE)
	find $(wildcard $(PACKAGES) tests benchmarks examples) -name __pycache__ -type d -prune -exec rm -rf {} +

$(RUN_READY): pyproject.toml | $(BIN)/pip
	$(BIN)/pip install -q --disable-pip-version-check -e .
	@touch $@

$(TEST_READY): pyproject.toml | $(BIN)/pip
	$(BIN)/pip install -q --disable-pip-version-check $(NO_BYTE_CODE) -e '.[test]'
	@touch $@ $(RUN_READY)

# Debian keeps venv's ensurepip in a package of its own; a failed attempt leaves half a folder, hence --clear.
$(BIN)/pip:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
		echo "Python 3.11 or newer is needed; try make PYTHON=python3.12" >&2; exit 1; }
	@$(PYTHON) -m venv $(VENV) || { echo "venv is missing, trying apt" >&2; $(HAS_APT) \
		&& $(APT) update && $(APT) install -y --no-install-recommends python3-venv \
		&& $(PYTHON) -m venv --clear $(VENV); } || { \
		rm -rf $(VENV); echo "install your system's python3-venv, then try again" >&2; exit 1; }
