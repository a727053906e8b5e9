"""Maps of buildings as layouts: occupancy grids and outlines."""
