"""Commands that fill a map or a data set, chunk by chunk."""
