"""Interactive windows and pages."""
