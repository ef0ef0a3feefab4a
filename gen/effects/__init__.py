"""Kinds of effects, one file each: what it says, how it is read, how it moves sites. `kinds.py` lists them."""
