"""What the node makes of faults, over real DDS: a verdict for each."""
