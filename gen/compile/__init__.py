"""From a spec to C: select, derive, lower, plan, emit; each stage reads only what those before it made."""
