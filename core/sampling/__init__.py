"""The paper's loop for mode UNBIASED: rounds of samples, and when to stop."""
