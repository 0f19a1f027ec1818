"""The judge of the estimator: stated intervals and errors against the truth of simulated drives."""
