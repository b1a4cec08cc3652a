"""Planning between any two states of motion: one axis or several, one problem or many."""
