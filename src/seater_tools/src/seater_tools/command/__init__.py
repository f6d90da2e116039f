"""The commands of `./seater calibrate` and `./seater teach`, as a person types them."""
