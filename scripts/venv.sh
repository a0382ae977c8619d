#!/bin/bash
# Print the Python of a virtual environment that holds IWIS and bpy, making it first if need be.
#
#   PYTHON=python3.11 VENV=.venv-mine scripts/venv.sh
#
# PYTHON: which interpreter to use; else Python 3.13 (bpy 5.2), else 3.11 (bpy 4.5), from PATH or pyenv
# VENV:   folder of the environment; else .venv-py313 or .venv-py311 in the checkout
# Whatever else is said goes to standard error.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

usable() { # a pyenv shim may be on PATH and yet not run: only running tells
    [ "$("$1" -c 'import sys; print(sys.version_info[:2] in ((3, 11), (3, 13)))' 2>/dev/null)" = True ]
}

find_python() {
    local name candidate
    for name in "$@"; do
        for candidate in "$name" "${PYENV_ROOT:-$HOME/.pyenv}"/versions/*/bin/"${name##*/}"; do
            if usable "$candidate"; then
                command -v "$candidate"
                return
            fi
        done
    done
    return 1
}

if [ -n "${PYTHON:-}" ]; then
    python=$(find_python "$PYTHON") || {
        echo "iwis: PYTHON=$PYTHON is no Python 3.11 or 3.13 that runs" >&2
        exit 1
    }
else
    python=$(find_python python3.13 python3.11 python3) || {
        echo "iwis: no Python 3.13 or 3.11 found, the versions that bpy exists for (Debian 12: apt-get install python3 python3-venv); PYTHON=/path/to/python names one" >&2
        exit 1
    }
fi
exec "$python" "$root/scripts/setup_venv.py" ${VENV:+"$VENV"}
