"""A bag published to a running graph, where rosbag2 is not installed."""
