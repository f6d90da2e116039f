"""From messages, images and files to observations; and the drive of `--move`."""
