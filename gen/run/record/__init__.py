"""What a run records: columns, conserved quantities, the largest deviations."""
