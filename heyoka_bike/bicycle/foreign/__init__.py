"""Bicycles from files of others: parameter files of BicycleParameters, and models of engines."""
