"""Programs and page of the study of round-off."""
