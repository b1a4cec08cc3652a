"""Motions through several points: the route, the program that times it, the legs as planned."""
