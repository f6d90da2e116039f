"""What the perception commands share: camera, renderer, Cramer-Rao bound, peers. No ROS."""
