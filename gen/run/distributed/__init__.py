"""`smidgen run --distributed`: every rank of MPI stores its own part of a lattice alone, and writes it to the result itself."""
