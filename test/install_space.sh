#!/usr/bin/env bash
# The install space serves by itself: installs the built workspace afresh and docks from there.
# usage: install_space.sh ROOT
set -euo pipefail
root=$1 prefix=$1/install
# CATKIN_IGNORE stays: without it, other tests that run meanwhile would find packages here that are just being removed.
mkdir -p "$prefix" && touch "$prefix/CATKIN_IGNORE"
find "$prefix" -mindepth 1 -maxdepth 1 ! -name CATKIN_IGNORE -exec rm -rf {} +
cmake --install "$root/build"
# Nothing of the build or devel space may help.
unset CMAKE_PREFIX_PATH ROS_PACKAGE_PATH PYTHONPATH LD_LIBRARY_PATH PKG_CONFIG_PATH ROSLISP_PACKAGE_DIRECTORIES
set +u
# shellcheck disable=SC1091
source "$prefix/setup.bash"
set -u
for package in seater_perception seater_nmpc seater_sim seater_bringup seater_config; do
  found=$(rospack find "$package")
  case "$found" in "$prefix"/*) ;; *) echo "$package is found in $found, not in $prefix"; exit 1 ;; esac
done
rosrun seater_perception detect_image --help
rosrun seater_eval dock_run --start "-0.6 0 0" --images none --results "$root/results/test/installed_dock"
