"""Resources of the computer: files, processes, the folders of the package."""
