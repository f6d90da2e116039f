"""The rospy adapter of seater_nmpc: messages in, messages out, nothing else."""
