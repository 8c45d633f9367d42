"""Commands of the workbench, as those of the package."""
