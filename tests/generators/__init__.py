"""Files, bicycles, states, sets and reports that are made, with errors that are known."""
