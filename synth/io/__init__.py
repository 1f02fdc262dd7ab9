"""Files, whole or not at all: images, videos, flows, folders of frames."""
