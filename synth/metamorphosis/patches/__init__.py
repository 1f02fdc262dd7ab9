"""Textures in between, made of patches warped and blended from several exemplars (Ruiters et al. 2010)."""
