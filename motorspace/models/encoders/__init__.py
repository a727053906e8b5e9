"""Motor encoders: a motor sequence in, a latent code out. One sequence; batching is `vmap`."""
