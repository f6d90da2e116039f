"""The moving chair: motors and their controller, wheel odometry."""
