"""Stage `derive`: one representative term of each effect, and its derivatives."""
