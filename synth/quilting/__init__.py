"""Graph-cut quilting of images and video (thesis chapter 3)."""
