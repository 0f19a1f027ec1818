"""How a fleet of bags fares: speed on several cores, memory, damaged bags, killed workers."""
