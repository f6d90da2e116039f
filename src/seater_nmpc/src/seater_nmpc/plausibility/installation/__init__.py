"""Whether the camera sits on the chair where it is said to, and its focal length is right: by many images on a way."""
