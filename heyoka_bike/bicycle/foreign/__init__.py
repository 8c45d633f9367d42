"""Bicycles from files of other programs: BicycleParameters, and models of physics engines."""
