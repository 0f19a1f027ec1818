# `make` lists the targets. Each sets up what it needs first.

PYTHON ?= python3
VENV := .venv/bin

# What is imported once, tests with their assertions included, need not be compiled again.
unexport PYTHONDONTWRITEBYTECODE

.DEFAULT_GOAL := help
.PHONY: help setup loops-later demo test lint collect figures bench bench-mechanics \
	bench-coverage bench-estimation bench-alarms bench-graph bench-replay bench-hostile \
	bench-faults clean distclean

help:  ## list these targets
	@awk -F ':.*## +' '/^[a-z-]+:.*##/ { printf "  make %-18s%s\n", $$1, $$2 }' Makefile

setup:  ## make .venv: ROS 2, belt_ros, its messages, its tools
	@command -v $(PYTHON) >/dev/null || { \
	  echo "No $(PYTHON) here. Install it with:" >&2; \
	  echo "  sudo apt install python3 python3-venv python3-dev g++" >&2; exit 1; }
	@$(PYTHON) tools/setup_environment.py

demo: setup  ## run the demonstration; BAG=<bag> CONFIG=<yaml> for your own data
	@$(VENV)/belt demo $(if $(BAG),--bag "$(BAG)") $(if $(CONFIG),--config "$(CONFIG)")

test: setup  ## run all tests; PYTEST_ARGS="-k alarm" for some of them
	@$(VENV)/python -m pytest -n 3 --dist loadscope --no-loadscope-reorder $(PYTEST_ARGS)

loops-later:
	@$(PYTHON) tools/setup_environment.py --leave-loops

lint: loops-later  ## check style, types and the direction of imports
	@$(VENV)/ruff check .
	@$(VENV)/ruff format --check .
	@$(VENV)/mypy
	@$(VENV)/lint-imports --no-logo

collect: loops-later  ## check that all tests can be collected; spares their workers to compile them
	@found=$$($(VENV)/python -m pytest --collect-only -qqq) || { echo "$$found"; exit 1; }

figures: setup  ## draw the paper's figures and tables into docs/figures
	@$(VENV)/belt figures --out docs/figures

bench: bench-mechanics bench-coverage bench-estimation bench-alarms bench-graph bench-replay bench-hostile bench-faults  ## run all benchmarks

bench-mechanics: setup  ## measure the speed of arcs and finite elements; BENCH_ARGS=--exudyn
	@$(VENV)/python -m benchmarks.mechanics $(BENCH_ARGS)

bench-coverage: setup  ## measure whether stated intervals hold the truth
	@$(VENV)/python -m benchmarks $(BENCH_ARGS)

bench-estimation: setup  ## judge the estimator: grid, life, finite elements, others, cost; resumable
	@$(VENV)/python -m benchmarks.estimation grid $(BENCH_ARGS)
	@$(VENV)/python -m benchmarks.estimation near $(BENCH_ARGS)
	@$(VENV)/python -m benchmarks.estimation life $(BENCH_ARGS)
	@$(VENV)/python -m benchmarks.estimation elements $(BENCH_ARGS)
	@$(VENV)/python -m benchmarks.estimation peers $(BENCH_ARGS)
	@$(VENV)/python -m benchmarks.estimation cost $(BENCH_ARGS)

bench-alarms: setup  ## ramps to gross slip, hours of varying load: are alarms early, and quiet?
	@$(VENV)/python -m benchmarks.alarms $(BENCH_ARGS)

bench-graph: setup  ## rates, latency, fifty drives, kill -9: the node as a process among others
	@$(VENV)/python -m benchmarks.graph rate $(BENCH_ARGS)
	@$(VENV)/python -m benchmarks.graph latency $(BENCH_ARGS)
	@$(VENV)/python -m benchmarks.graph drives $(BENCH_ARGS)
	@$(VENV)/python -m benchmarks.graph kill $(BENCH_ARGS)

bench-replay: setup  ## samples a second, cores and memory of replay, beside reading the bag alone
	@$(VENV)/python -m benchmarks.replay $(BENCH_ARGS)

bench-hostile: setup  ## a million hostile messages through conversion and monitor, and ten thousand by hypothesis
	@$(VENV)/python -m benchmarks.hostile $(BENCH_ARGS)
	@HOSTILE_EXAMPLES=170 $(VENV)/python -m pytest -q --timeout 3600 tests/node/test_hostile.py

bench-faults: setup  ## faults of belt, sensors and network over DDS: the right alarm, in time?
	@$(VENV)/python -m benchmarks.faults $(BENCH_ARGS)

clean:  ## remove what building and testing leave
	@rm -rf build install log .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis
	@rm -rf *.egg-info
	@find belt_ros tests tools -name __pycache__ -type d -prune -exec rm -rf {} +

distclean: clean  ## remove .venv too
	@rm -rf .venv
