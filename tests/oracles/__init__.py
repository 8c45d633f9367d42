"""Independent models to compare the package with; README.md lists what each shares with it."""
