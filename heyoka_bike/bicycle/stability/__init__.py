"""The linearised bicycle, and critical speeds proved over boxes of parameters."""
