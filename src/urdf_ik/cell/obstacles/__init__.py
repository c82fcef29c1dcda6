"""The obstacles of a world by place: a tree of boxes, and an index of what stands where."""
