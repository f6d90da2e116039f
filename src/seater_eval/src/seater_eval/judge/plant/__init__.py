"""The independent chair: drive, wheels on a floor, castors, encoders, camera. Plain floats at 200 Hz, no ROS."""
