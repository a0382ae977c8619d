"""What a Scene is made of, as plain data; loads without numba, for exporters too."""
