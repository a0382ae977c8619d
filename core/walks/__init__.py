"""Light that walks under surfaces."""
