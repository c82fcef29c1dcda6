"""Whether Pinocchio is installed, and what stands for it where it is not."""
