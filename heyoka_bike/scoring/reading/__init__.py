"""Reading of another program's results: text, NumPy, MATLAB and HDF5 files, and arrays."""

from heyoka_bike.scoring.reading.source import read_results as read_results
