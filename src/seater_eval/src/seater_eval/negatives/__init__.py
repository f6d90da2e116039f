"""Images that show no marker of a dictionary: what perception finds in them all the same. perception_negatives."""
