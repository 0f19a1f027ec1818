"""Speed of the mechanics, as ratios within one run."""
