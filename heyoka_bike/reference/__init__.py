"""The published dataset: its files, and reading them with NumPy and h5py only."""
