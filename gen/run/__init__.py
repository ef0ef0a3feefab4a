"""Stage `run`: a compiled model steps numpy arrays; settings, records, results, checkpoints."""
