"""What several tests share: the shipped systems, exact solutions, tangents, strict compilers."""
