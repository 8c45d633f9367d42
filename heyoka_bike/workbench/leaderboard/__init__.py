"""Submissions in a folder, scored and ranked."""
