"""Who may use the panel: the token, and from which address the page has to come. No ROS."""
