"""The reference as plain files for programs without HDF5 or Python: one module for each format.

Each module has ``SUFFIXES`` and ``render(selection, stem)``, which gives the bytes of each file by
the ending that its name has after the stem (``.h``, ``-1.csv``). What all of them need is in
`selection`. `equations` has another `render`: it writes the equations of motion, in a file for each
language.
"""
