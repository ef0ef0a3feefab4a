"""The study of round-off: programs that measure, what they measure, and the page of it."""
