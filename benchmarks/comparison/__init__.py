"""Our solver beside other engines on the same work: who runs what, in which process, how good, how fast."""
