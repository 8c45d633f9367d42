"""Critical speeds of every bicycle in a box of parameters, proved."""
