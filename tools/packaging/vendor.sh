#!/usr/bin/env bash
# Fetch what the nodes import and Debian 12 does not have, for the Debian package, in the versions of
# tools/requirements*.txt.
# usage: vendor.sh DIR
# What else is pinned there is for development and comparisons, and no node imports it.
set -euo pipefail
folder=${1:?usage: vendor.sh DIR}
tools="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
needed='casadi|piqp|pyrealsense2'

unset PYTHONPATH PYTHONHOME VIRTUAL_ENV
rm -rf "$folder"
# Their own requirements, NumPy and SciPy, are Debian's.
grep -hE "^($needed)==" "$tools"/requirements.txt "$tools"/requirements_realsense.txt |
  /usr/bin/python3 -m pip install --quiet --disable-pip-version-check --no-deps --no-compile --only-binary :all: \
    --target "$folder" -r /dev/stdin
# For compiling against CasADi, its command line, and the record of files that are no longer all there.
rm -rf "$folder"/{bin,dummy.txt} "$folder"/casadi/{include,cmake,pkgconfig,casadi-cli}
rm -f "$folder"/*.dist-info/{RECORD,INSTALLER,REQUESTED}
find "$folder" \( -name '*.la' -o -name '*.debug' \) -delete
# A wheel has no symbolic links: each library of CasADi is there three times.
hardlink -q "$folder"
