"""Many runs: ensembles of states in one call, sweeps over values and starts, on many machines."""
