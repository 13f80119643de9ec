"""The report of a run: one HTML file with plots, cursors, axis states, events and the program; needs no network."""
