"""Reading of results from text, NumPy, MATLAB, HDF5 and other files, and from arrays."""
