"""Estimators that no picture uses, to compare with."""
