"""What pixels keep beside their light, and sums to layers of the film."""
