"""What ROS bags are made of: containers of messages, and the messages of robots."""
