"""What the package is compared with; README.md says what each shares with it."""
