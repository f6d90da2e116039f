"""Which stage of the docking fails first, from what all nodes say on /diagnostics. ROS-free."""
