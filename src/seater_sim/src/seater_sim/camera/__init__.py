"""From the scene to an image: camera model, projection, prints, sensor."""
