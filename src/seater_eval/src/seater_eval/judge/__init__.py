"""The docking sequence judged on a chair of its own: shares no code and no assumption with seater_sim."""
