"""Submissions of a folder, scored and ranked."""
