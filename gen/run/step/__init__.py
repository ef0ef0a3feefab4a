"""Values and starts of a spec; a compiled model that steps numpy arrays; the head of its saved states."""
