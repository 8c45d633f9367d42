"""Number types and numerical methods that do not depend on the bicycle."""
