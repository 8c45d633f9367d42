"""Imported once in the process that all others are copies of: what they need is there already."""

from heyoka_bike.serving.tasks import warm

warm()
