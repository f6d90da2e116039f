#!/usr/bin/env bash
# Put other people's marker detectors into an environment of their own, beside which the perception commands compare
# (option --peers DIR). Nothing else of the project sees it: their NumPy and OpenCV are not Debian's.
# usage: make_peers.sh DIR
# Does nothing when DIR was already made from the same requirements.
set -euo pipefail
folder=${1:?usage: make_peers.sh DIR}
requirements="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)/requirements_peers.txt"

cmp -s "$requirements" "$folder/ready" && exit 0
unset PYTHONPATH PYTHONHOME VIRTUAL_ENV
/usr/bin/python3 -m venv "$folder"
"$folder/bin/python3" -m pip install --quiet --disable-pip-version-check -r "$requirements"
cp "$requirements" "$folder/ready"
