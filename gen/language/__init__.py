"""What a spec is: plain data, its expressions, their values, its limits."""
