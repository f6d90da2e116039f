#!/usr/bin/env bash
# Put acados into a folder of its own, beside which `rosrun seater_eval solver_benchmark --acados DIR` compares.
# usage: make_acados.sh DIR
# The package carries acados, HPIPM, BLASFEO, the template renderer, and a CasADi for another Python, which is removed.
set -euo pipefail
folder=${1:?usage: make_acados.sh DIR}
requirements="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)/requirements_acados.txt"

cmp -s "$requirements" "$folder/ready" && exit 0
/usr/bin/python3 -m pip install --quiet --disable-pip-version-check --no-deps --upgrade --target "$folder" \
  -r "$requirements"
rm -rf "$folder/casadi"
cp "$requirements" "$folder/ready"
