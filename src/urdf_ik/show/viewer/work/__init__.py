"""What makes the viewer a tool: text to paste and copy, postures, keys, another arm, uploads, the saved page."""
