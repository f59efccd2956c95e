"""Pages of HTML with everything inside."""
