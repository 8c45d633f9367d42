"""What several tests use: files of programs with known errors, small projects, sets made anew."""
