"""Light sources, one a file, and the choice among them."""
