"""The parts of emission, one kind of C text each; `Emitter` in gen/emit.py puts them together."""
