"""Images of markers with a known truth: camera, renderer, poses, images without markers, and the bound of what they
tell."""
