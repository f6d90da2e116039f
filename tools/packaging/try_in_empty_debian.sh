#!/usr/bin/env bash
# Install the Debian package in an empty Debian 12, dock there as an ordinary user, upgrade it, remove it.
# usage: try_in_empty_debian.sh PACKAGE.deb FOLDER [WHEEL]
# FOLDER: for the empty Debian; must not be there yet, stays for a look at the results. WHEEL (seater_core-*.whl): is
# installed with its requirements from PyPI and runs, too. Needs root and debootstrap, minutes, and 5 GB.
# The last line is "all as it should be".
set -euo pipefail
# The mounts below go with this process.
[ -n "${SEATER_UNSHARED:-}" ] || exec env SEATER_UNSHARED=1 unshare --mount --propagation private "$0" "$@"
package=$(realpath "${1:?usage: try_in_empty_debian.sh PACKAGE.deb FOLDER [WHEEL]}")
debian=${2:?usage: try_in_empty_debian.sh PACKAGE.deb FOLDER [WHEEL]}
wheel=${3:-}
home=home/person

say() { printf '\n== %s\n' "$*"; }
fail() { printf 'NOT AS IT SHOULD BE: %s\n' "$*"; exit 1; }
timed() { local start=$SECONDS; "$@"; printf '(%s s)\n' $((SECONDS - start)); }
inside() {
  chroot "$debian" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"
}
# In the home folder of an account without any rights, by a login shell.
as_person() { inside runuser -l person -c "$*"; }
# What the package may have left: whatever bears its name, but for people's own files and the log of apt.
footprint() {
  local skipped='-path /proc -o -path /home -o -path /tmp -o -path /root'
  inside sh -c "find / -xdev \\( $skipped \\) -prune -o -name '*seater*' -print"
}

empty_debian() {
  [ ! -e "$debian" ] || fail "$debian is there already"
  debootstrap --variant=minbase --include=ca-certificates bookworm "$debian" http://deb.debian.org/debian >/dev/null
  cp -L /etc/resolv.conf "$debian/etc/"
  # Where the network has a certificate of its own.
  cp -L /etc/ssl/certs/ca-certificates.crt "$debian/etc/ssl/certs/"
  echo force-unsafe-io >"$debian/etc/dpkg/dpkg.cfg.d/unsafe-io" # nobody keeps this Debian
  mount -t proc proc "$debian/proc"
  mount -t tmpfs tmpfs "$debian/dev/shm"
  mount -t devpts devpts "$debian/dev/pts"
  inside useradd --create-home --shell /bin/bash person
}

install_package() {
  cp "$package" "$debian/root/"
  inside apt-get update -qq
  inside sh -c "cd /root && apt-get install -y -qq ./$(basename "$package")" >"$debian/root/install.log" 2>&1 ||
    { tail -n 30 "$debian/root/install.log"; fail "installing"; }
  inside sh -c 'dpkg-query -W -f "\${Package}\n" | wc -l; dpkg --audit; du -sh /usr/lib/seater'
}

dock() {
  as_person seater dock || fail "seater dock ended with $?"
  for file in summary.json trajectory.png run.bag; do
    [ -s "$debian/$home/results/dock/$file" ] || fail "no results/dock/$file"
  done
}

# Each command for people, as far as it goes without a chair; what is for developers refuses.
other_commands() {
  as_person seater help | grep -q "seater dock" || fail "seater help"
  local commands=(campaign identify installation sheets "calibrate camera" "calibrate mount" panel teach doctor history)
  for command in "${commands[@]}"; do
    as_person seater "$command" --help >/dev/null || fail "seater $command --help"
  done
  as_person seater installation chair | tail -n 1 | grep -q "seater sheets" || fail "seater installation"
  as_person seater sheets --installation chair >/dev/null || fail "seater sheets"
  # Some checks need a running system; but none may be wrong.
  as_person seater doctor || fail "seater doctor"
  as_person seater run roslaunch --ros-args seater_bringup wheelchair.launch >/dev/null || fail "wheelchair.launch"
  as_person seater identify || fail "seater identify"
  local said
  for command in test lint sanitize package setup build; do
    if said=$(as_person seater $command 2>&1) || ! grep -q "needs the sources" <<<"$said"; then
      fail "seater $command does not refuse: $said"
    fi
  done
  # Where nothing can be written, results go home.
  rm -rf "${debian:?}/$home/results"
  as_person "cd /usr && seater dock --start '-1 0 0' --images none" || fail "seater dock in a folder of root's"
  [ -s "$debian/$home/results/dock/summary.json" ] || fail "results are not in the home folder"
}

# Another version, whose controller.yaml is another one, too: what was edited here stays.
upgrade() {
  local newer=$debian/root/newer
  dpkg-deb -R "$package" "$newer"
  sed -i 's/^Version: .*/&+next/' "$newer/DEBIAN/control"
  echo "# a new line of the newer version" >>"$newer/etc/seater/controller.yaml"
  dpkg-deb --root-owner-group -Znone -b "$newer" "$debian/root/newer.deb" >/dev/null
  rm -rf "$newer"
  for file in chair controller; do echo "# edited here" >>"$debian/etc/seater/$file.yaml"; done
  echo "# of this site" >"$debian/etc/seater/docks/ours.yaml"
  inside apt-get install -y -qq -o Dpkg::Options::=--force-confold /root/newer.deb >"$debian/root/upgrade.log" 2>&1 ||
    { tail "$debian/root/upgrade.log"; fail "upgrading"; }
  inside dpkg-query -W -f '${Version}\n' seater | grep -q '+next$' || fail "the version is the old one"
  for file in chair controller; do
    is_edited $file || fail "the upgrade has lost the edited $file.yaml"
  done
  [ -f "$debian/etc/seater/controller.yaml.dpkg-dist" ] || fail "the new controller.yaml is not beside the edited one"
}

is_edited() { tail -n 1 "$debian/etc/seater/$1.yaml" | grep -q "edited here"; }

remove() {
  inside apt-get remove -y -qq seater >/dev/null 2>&1
  [ ! -e "$debian/usr/lib/seater" ] || fail "removing leaves $(find "$debian/usr/lib/seater" | head -n 5)"
  is_edited chair || fail "removing has taken the edited chair.yaml"
  inside apt-get purge -y -qq seater >/dev/null 2>&1
  [ "$(footprint)" = /etc/seater ] || fail "purging leaves $(footprint)"
  [ "$(find "$debian/etc/seater" -type f)" = "$debian/etc/seater/docks/ours.yaml" ] ||
    fail "in /etc/seater there is $(find "$debian/etc/seater")"
  [ -s "$debian/$home/results/dock/summary.json" ] || fail "the person's results are gone"
}

# pip with the requirements from PyPI, in an environment that does not see Debian's Python packages.
core() {
  install -m 644 "$wheel" "$debian/tmp/"
  inside apt-get install -y -qq --no-install-recommends python3-venv >/dev/null 2>&1
  sed -n '/^from seater_common.geometry/,/^print(pose)/p' "$(dirname "$0")/../../README.md" >"$debian/tmp/ten_lines.py"
  chmod 644 "$debian/tmp/ten_lines.py"
  as_person "python3 -m venv core && core/bin/pip --quiet install '/tmp/$(basename "$wheel")[lens]'" || fail "pip install"
  as_person core/bin/pip list
  as_person "core/bin/python3 /tmp/ten_lines.py" || fail "the ten lines"
}

say "an empty Debian 12"
timed empty_debian
say "apt install ./$(basename "$package")"
timed install_package
say "seater dock"
timed dock
say "the other commands"
timed other_commands
if [ -n "$wheel" ]; then
  say "the controller by pip"
  timed core
fi
say "upgrade"
timed upgrade
say "remove, purge"
timed remove
say "all as it should be"
