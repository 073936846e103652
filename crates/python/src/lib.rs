//! The Python door: `frangible._frangible`, thin over the engine.
