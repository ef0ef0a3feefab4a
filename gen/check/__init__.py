"""Compiled code against what it should be: an independent witness, and the certificate of `verify`."""
