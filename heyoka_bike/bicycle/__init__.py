"""What is given, and what is asked: a bicycle, its maneuvers, the columns."""
