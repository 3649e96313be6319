"""Light straight from cell to cell: what techniques that gather from nested windows or an octree share."""
