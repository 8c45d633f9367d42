"""What the computer gives: files, processes, the folders of the package."""
