"""What is kept: what record.launch records, but for images and plans. Latched topics are kept by their last message."""

DOCK, UNDOCK = "dock", "undock"  # the actions
TOPICS = (
    "odom", "detections", "dock_pose_filtered", "velocity_request", "cmd_vel", "cmd_vel_stamped", "motor_enable",
    "gate_state", "speed_limit", "user_cmd_vel", "emergency_stop", "hold_to_run", "motor_fault", "controller_status",
    "innovations", "dock_in_use", "dock_state", "charging_contact", "obstacles",
    *(f"{action}/{part}" for action in (DOCK, UNDOCK) for part in ("goal", "cancel", "feedback", "result")),
    "/tf", "/tf_static", "/diagnostics", "/rosout",
)  # fmt: skip
