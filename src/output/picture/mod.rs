//! Pictures of frames.
