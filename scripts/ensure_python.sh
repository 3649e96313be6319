#!/bin/sh
# ensure_python.sh PYTHON: makes sure that PYTHON is new enough and can make virtual environments.
set -eu
python=$1
another="Name another one, such as: make PYTHON=python3.12 demo"
if ! command -v "$python" >/dev/null; then
    echo "error: there is no '$python'. octolux needs Python 3.11 or newer. $another" >&2
    exit 1
fi
if ! "$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))'; then
    echo "error: octolux needs Python 3.11 or newer; '$python' is $("$python" -V 2>&1). $another" >&2
    exit 1
fi
if ! "$python" -c 'import ensurepip, venv' 2>/dev/null; then
    package=$("$python" -c 'import sys; print("python%d.%d-venv" % sys.version_info[:2])')
    exec sh "$(dirname "$0")/apt_install.sh" "the venv module of '$python'" "$package"
fi
