"""Maps in stores: filled block by block, read in parts, cut, joined and compared without being read whole."""
