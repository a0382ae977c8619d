"""Small scenes, one for each node, setting and combination, rendered by IWIS and by Cycles."""
