"""Generated files, bicycles, states, datasets and reports, with known errors."""
