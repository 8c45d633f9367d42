"""Imported once in the process that all others are copies of: what they need is there already."""

from heyoka_bike.workbench.serving.tasks import warm

warm()
