"""The ROS 2 node: parameters in, joint states in, belt state, slip alarm and diagnostics out."""
