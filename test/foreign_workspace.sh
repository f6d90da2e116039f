#!/usr/bin/env bash
# The repository as a folder in somebody else's catkin workspace: configuring works with an interpreter that knows
# casadi and piqp, and another one is refused with the remedy.
# SEATER_EXTENSIVE in the environment: every package.
# usage: foreign_workspace.sh ROOT BUILD_FOLDER PYTHON
set -euo pipefail
root=$1 workspace=$2/foreign_workspace python=$3
rm -rf "$workspace" && mkdir -p "$workspace/src/seater"
# Without the build folder, which lies in the repository here and would hold this workspace itself.
ln -s "$root"/{src,config,test} "$workspace/src/seater/"
ln -s "$(pkg-config --variable=prefix catkin)/share/catkin/cmake/toplevel.cmake" "$workspace/src/CMakeLists.txt"
unset CMAKE_PREFIX_PATH ROS_PACKAGE_PATH PYTHONPATH LD_LIBRARY_PATH PKG_CONFIG_PATH

configure() {
  cmake -S "$workspace/src" -B "$workspace/build" -DPYTHON_EXECUTABLE="$1" -DPython3_EXECUTABLE="$1" "${@:2}" 2>&1
}

# One package is enough to be refused.
if refusal=$(configure /usr/bin/python3 -DCATKIN_WHITELIST_PACKAGES=seater_nmpc); then
  # Somebody has installed casadi and piqp for all users: then there is nothing to refuse.
  /usr/bin/python3 -c "import casadi, piqp"
elif ! grep -q "cannot import casadi and piqp" <<<"$(tr -s ' \n' ' ' <<<"$refusal")"; then
  printf '%s\n' "the refusal does not name what is missing:" "$refusal"
  exit 1
fi
rm -rf "$workspace/build"
# Every package with `./seater test --all`, else those that ask most of their surroundings.
some=()
[[ -v SEATER_EXTENSIVE ]] || some=("-DCATKIN_WHITELIST_PACKAGES=seater_msgs;seater_nmpc;seater_perception;seater_safety")
configure "$python" "${some[@]}"
grep -q seater_nmpc "$workspace/build/catkin_generated/order_packages.cmake"
