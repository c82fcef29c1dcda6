"""The npm module `urdf-ik`, and the page that is made of it."""
