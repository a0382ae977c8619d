"""Pictures without their noise, by Open Image Denoise."""
