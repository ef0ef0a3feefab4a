"""What can be said of a model and its runs: symmetries, the largest safe step, exponents, sections."""
