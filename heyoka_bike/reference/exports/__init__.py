"""The reference and its equations as plain files, for programs without HDF5 or Python."""
