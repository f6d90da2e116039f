#!/usr/bin/env bash
# Build the Debian package from the sources as they are, by dpkg-buildpackage, in a copy of them.
# usage: build_deb.sh ROOT WORK_FOLDER RESULT_FOLDER
set -euo pipefail
root=$1 work=$2 results=$3
sources=(CHANGELOG.md CMakeLists.txt LICENSE README.md config debian docs seater src tools)

rm -rf "$work"
mkdir -p "$work/seater" "$results"
tar -C "$root" --exclude=__pycache__ -cf - "${sources[@]}" | tar -C "$work/seater" -xf -
cd "$work/seater"

# Between releases each commit has a version of its own, by its time, so that apt sees an upgrade.
version=$(dpkg-parsechangelog -S Version)
if commit=$(git -C "$root" log -1 --abbrev=7 --format='%cd.%h' --date=format:%Y%m%d%H%M%S 2>/dev/null) &&
  [ "$(git -C "$root" describe --tags --exact-match 2>/dev/null)" != "v$version" ]; then
  snapshot="$version+git$commit"
  sed -i "1s/($version)/($snapshot)/" debian/changelog
fi
# What the package's own rules do not set must not leak in from a sourced ROS workspace or another Python.
unset CMAKE_PREFIX_PATH ROS_PACKAGE_PATH PYTHONPATH PYTHONHOME VIRTUAL_ENV LD_LIBRARY_PATH PKG_CONFIG_PATH
PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin
dpkg-buildpackage --build=binary --no-sign --jobs="$(nproc)"
rm -f "$results"/seater_*.deb
cp "$work"/seater_*.deb "$results"
