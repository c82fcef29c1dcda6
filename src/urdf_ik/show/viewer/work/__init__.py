"""What makes the viewer a tool: poses and joint vectors as text, postures, keys, the saved page."""
