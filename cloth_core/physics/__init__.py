"""The terms of a step, one module each: what acts on the cloth and what limits it."""
