#!/bin/sh
# The installed config/ becomes /etc/seater, whose files dpkg keeps as their owner edited them; seater_config points
# there.
# usage: move_config.sh STAGE FOLDER_OF_SEATER_CONFIG
set -eu
stage=$1 package=$2
mkdir -p "$stage/etc/seater"
for entry in "$stage/$package"/*; do
  name=$(basename "$entry")
  case "$name" in package.xml | cmake | catkin_env_hook) continue ;; esac
  mv "$entry" "$stage/etc/seater/$name"
  ln -s "/etc/seater/$name" "$entry"
done
