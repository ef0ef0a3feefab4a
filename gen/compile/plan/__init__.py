"""Stage `plan`: which sites are solved together, and by which solver."""
