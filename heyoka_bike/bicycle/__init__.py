"""The problem: a bicycle, its maneuvers, the columns, the equations and their linear form."""
