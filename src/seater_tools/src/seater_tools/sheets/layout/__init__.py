"""What goes where on the paper; all lengths in millimetres, y up. No drawing here."""
