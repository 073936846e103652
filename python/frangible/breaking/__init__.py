"""Breaking meshes without a simulation."""
