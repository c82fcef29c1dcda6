"""Following paths and targets: plans over all branches and turns, proven between the waypoints, and tracking."""
