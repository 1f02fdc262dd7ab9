"""Images from exemplars: synthesis, filling, guidance."""
