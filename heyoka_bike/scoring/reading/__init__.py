"""Reading of another program's results: text, NumPy, MATLAB and HDF5 files, and arrays."""
