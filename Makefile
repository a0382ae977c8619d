# IWIS: make render, make test, make zip. Each makes the virtual environment that it needs.
#
#   PYTHON=python3.11   the interpreter: 3.13 (bpy 5.2) or 3.11 (bpy 4.5); else the first one found
#   VENV=FOLDER         the environment's folder; else .venv-py313 or .venv-py311
#   ARGS="-k haar -x"   more arguments of pytest, of python -m iwis render, or of make bench
#   PLATFORM=linux-x64 PY=cp314   one zip instead of all
#   BLENDER=PROGRAM     what make test-blender runs, instead of Debian's Blender
#   OUT=FOLDER          where make render and make paper write; else out
#   DATA=FOLDER         the paper's data for make paper (docs/paper.md); else what is shipped

PYTHON ?=
VENV ?=
ARGS ?=
PLATFORM ?=
PY ?=
BLENDER ?=
OUT ?= out
DATA ?=

# Prints the environment's Python on standard output; quick when all is up to date.
venv_python = PYTHON="$(PYTHON)" VENV="$(VENV)" scripts/venv.sh

.PHONY: help render test parity whole-scenes random-scenes bench paper lint zip test-blender test-blender-render \
	test-blender-window venv clean distclean

help:
	@sed -n '1,/^$$/s/^# \{0,1\}//p' Makefile
	@echo "targets: render test parity whole-scenes random-scenes bench paper lint zip test-blender venv clean distclean"

# Render sample_blends/ through `python -m iwis render`: EXR and PNG in out/.
render:
	@python="$$($(venv_python))" && "$$python" scripts/render_samples.py "$(OUT)" $(ARGS)

test:
	@python="$$($(venv_python))" && "$$python" -m pytest $(ARGS)

# Every shader node beside Cycles: docs/parity.md.
parity:
	@python="$$($(venv_python))" && cd tests && "$$python" -m parity.run $(ARGS)

# Blender's templates, assets and add operators beside Cycles: docs/whole-scenes.md, 15 minutes.
whole-scenes:
	@python="$$($(venv_python))" && cd tests && "$$python" -m whole_scenes.run $(ARGS)

# Scenes by chance beside Cycles, 8 seconds each; ARGS="FIRST COUNT" takes other seeds than 0 to 99.
random-scenes:
	@python="$$($(venv_python))" && cd tests && "$$python" -m random_scenes.run $(ARGS)

# Error against CPU time beside Cycles and Mitsuba, scaling, start-up: docs/benchmarks.md, 20 minutes.
bench:
	@python="$$($(venv_python))" && "$$python" benchmarks/suite.py $(ARGS)

# Every figure and claim of the paper: OUT/paper.html, some minutes (docs/paper.md).
paper:
	@python="$$($(venv_python))" && "$$python" -m iwis paper --out "$(OUT)" \
		$(if $(DATA),--data "$(DATA)") $(ARGS)

lint:
	@python="$$($(venv_python))" && "$$python" -m ruff check . && "$$python" -m ruff format --check .

# The extension: dist/iwis-VERSION-PLATFORM-cpXY.zip
zip:
	@python="$$($(venv_python))" && "$$python" scripts/build_zip.py \
		$(if $(PLATFORM),--platform $(PLATFORM)) $(if $(PY),--python $(PY))

# A render, and edits in the window, by a real Blender program (Debian's own; root, 1 GB) with the
# zip installed; test-blender-render and test-blender-window are its two parts. ARGS=--quick: fewer
# edits; ARGS=--measure: latencies of the rendered view instead.
test-blender:
	@$(MAKE) --no-print-directory test-blender-render
	@$(MAKE) --no-print-directory test-blender-window

test-blender-render:
	@python="$$($(venv_python))" && "$$python" tests/real_blender/check_render.py \
		$(if $(BLENDER),--blender "$(BLENDER)")

test-blender-window:
	@python="$$($(venv_python))" && "$$python" tests/real_blender/check_window.py $(ARGS) \
		$(if $(BLENDER),--blender "$(BLENDER)")

venv:
	@$(venv_python)

clean:
	rm -rf build dist out *.egg-info .pytest_cache .ruff_cache
	find . -name __pycache__ -not -path './.venv*' -prune -exec rm -rf {} +

# Also what was downloaded.
distclean: clean
	rm -rf .venv* wheels
