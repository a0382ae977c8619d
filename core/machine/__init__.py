"""Threads, clocks, memory: what is nearer to the machine than to the picture."""
