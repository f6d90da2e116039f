#!/usr/bin/env bash
# Style, types and package manifests, as `./seater test` and the pre-commit hooks check them.
# usage: lint.sh [CHECK ...]   checks: catkin_lint clang_format mypy ruff_check ruff_format (default: all)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
PATH="$PWD/.venv/bin:$PATH"

lint_catkin_lint() {
  catkin_lint -W2 --strict src
  # config/ and test/ are named for people who look into the repository.
  catkin_lint -W2 --strict --ignore package_path_name config test
}
lint_clang_format() { find src \( -name '*.h' -o -name '*.cpp' \) -print0 | xargs -0 clang-format --dry-run --Werror; }
lint_mypy() {
  local sources=(src/*/src/seater_* test/src/seater_test)
  MYPYPATH=$(dirname "${sources[@]}" | paste -sd :) mypy "${sources[@]}"
}
lint_ruff_check() { ruff check .; }
lint_ruff_format() { ruff format --check .; }

checks=("$@")
[ $# -gt 0 ] || mapfile -t checks < <(declare -F | sed -n 's/^declare -f lint_//p')
for check in "${checks[@]}"; do
  declare -F "lint_$check" >/dev/null || { echo "lint.sh: unknown check: $check" >&2; exit 2; }
  "lint_$check"
done
