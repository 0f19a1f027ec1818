"""The node on the ROS graph: rate, latency, many drives, sudden death; real rclpy, real DDS."""
