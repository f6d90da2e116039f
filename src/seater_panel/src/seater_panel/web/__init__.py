"""The web server: page, images, and a WebSocket per page. No ROS."""
