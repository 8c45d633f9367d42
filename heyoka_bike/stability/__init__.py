"""Critical speeds of all bicycles whose parameters are within their uncertainties."""
