#!/usr/bin/env bash
# Make the virtual environment of the nodes (Debian's python3 with its ROS modules, plus pinned packages from PyPI).
# usage: make_venv.sh DIR
# Does nothing when DIR was already made from the same requirements.
set -euo pipefail
venv=${1:?usage: make_venv.sh DIR}
requirements="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)/requirements.txt"

cmp -s "$requirements" "$venv/ready" && exit 0
# PYTHONPATH or another activated environment must not leak in.
unset PYTHONPATH PYTHONHOME VIRTUAL_ENV
/usr/bin/python3 -m venv --system-site-packages "$venv"
"$venv/bin/python3" -m pip install --quiet --disable-pip-version-check -r "$requirements"
cp "$requirements" "$venv/ready"
