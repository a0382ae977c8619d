"""Pictures for a window: a coarse one at once, finer ones while it is looked at."""
