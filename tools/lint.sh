#!/usr/bin/env bash
# Style, types and package manifests, as `./seater test` and the pre-commit hooks check them.
# usage: lint.sh [CHECK ...]   checks: catkin_lint clang_format mypy ruff_check ruff_format (default: these), clang_tidy
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
PATH="$PWD/.venv/bin:$PATH"

lint_catkin_lint() {
  catkin_lint -W2 --strict src
  # config/ and test/ are named for people who look into the repository.
  catkin_lint -W2 --strict --ignore package_path_name config test
}
lint_clang_format() { find src \( -name '*.h' -o -name '*.cpp' \) -print0 | xargs -0 clang-format --dry-run --Werror; }
# Takes minutes. Needs a build; clang reads neither GCC's precompiled headers nor has it its OpenMP, so the commands are
# taken without them.
lint_clang_tidy() {
  [ -f build/compile_commands.json ] || { echo "lint.sh: build first (./seater build)" >&2; exit 2; }
  mkdir -p build/clang_tidy
  sed -E 's# -(Winvalid-pch|fopenmp)##g; s# -include [^ ]*/cmake_pch\.hxx##' build/compile_commands.json \
    >build/clang_tidy/compile_commands.json
  run-clang-tidy -quiet -j "$(nproc)" -p build/clang_tidy "^$PWD/src/seater_[a-z]+/(src|python)/"
}
lint_mypy() {
  local sources=(src/*/src/seater_* test/src/seater_test)
  # ROS puts Debian's modules before the environment's; its pathspec is too old for mypy.
  env -u PYTHONPATH MYPYPATH="$(dirname "${sources[@]}" | paste -sd :)" mypy "${sources[@]}"
}
lint_ruff_check() { ruff check .; }
lint_ruff_format() { ruff format --check .; }

checks=("$@")
[ $# -gt 0 ] || checks=(catkin_lint clang_format mypy ruff_check ruff_format)
for check in "${checks[@]}"; do
  declare -F "lint_$check" >/dev/null || { echo "lint.sh: unknown check: $check" >&2; exit 2; }
  "lint_$check"
done
